module bw_unprojected
  !! Errors of the state after a change of bodies, as only finitely many modes before it are projected. The omitted
  !! modes k lie far above the modes j after the change that matter, and each contributes an impulse (m −
  !! k_v/β_k²)Φ̄_jΦ_kq̇_k of an arriving or leaving body with mass m and stiffness k_v, and likewise for rotation. Their
  !! phases are practically random, so squares add up; their sum per octave falls as in the last two octaves. Runs with
  !! fewer modes do not show this error: if phases happen to cancel, they agree although all are wrong.
  !!
  !! A body that arrives with a velocity takes none from the beam, only its deflection. Arriving springs are unstressed
  !! at a deflection without the omitted modes. **Limit**: tension that arrives or leaves with a body is neglected; its
  !! effect is smaller by 1/β_k². Units of bw_segment.
  use bw_change_of_bodies, only: body_type
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: unprojected_errors

contains

  pure function unprojected_errors(before, q, rate, after, bodies, was, is) result(doubt)
    !! Return twice the rms errors of modal displacements and velocities after the change, (modes after, 2).
    class(mode_set), intent(in) :: before, after
    real(dp), intent(in) :: q(:), rate(:)          !! of the projected modes before
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: was(:), is(:)           !! bodies before and after, (bodies)
    real(dp) :: doubt(after%count, 2)
    real(dp) :: inert(2), elastic(2), seen(before%count, 2), shape(after%count, 2), blow(size(q)), reach(size(q))
    logical :: brings                              ! a velocity
    real(dp), parameter :: lowest = 1.0_dp          ! β² below it belongs to rigid modes, which springs do not bend
    integer :: b, c
    doubt = 0.0_dp
    associate (square => max(abs(before%beta_squared(:size(q))%hi), lowest), &
               square_after => max(abs(after%beta_squared%hi), lowest))
      reach = sqrt(rate**2 + square*q**2)
      do b = 1, size(bodies)
        if (was(b) .eqv. is(b)) cycle
        inert = [bodies(b)%mass, bodies(b)%inertia]
        brings = is(b) .and. .not. is_missing(bodies(b)%velocity)
        elastic = [bodies(b)%stiffness, bodies(b)%turning_stiffness]
        seen = before%motion_at(bodies(b)%position)
        shape = abs(after%motion_at(bodies(b)%position))
        do c = 1, 2
          blow = (inert(c) + elastic(c)/square)*abs(seen(:size(q), c))*reach
          if (.not. brings) doubt(:, 2) = doubt(:, 2) + shape(:, c)*rms_of_omitted(blow)
          doubt(:, 1) = doubt(:, 1) + shape(:, c)*rms_of_omitted(blow/sqrt(square))
          if (is(b)) doubt(:, 1) = doubt(:, 1) + shape(:, c)*elastic(c)/square_after &
            *rms_of_omitted(abs(seen(:size(q), c))*reach/sqrt(square))
        end do
      end do
    end associate
    doubt = doubt/spread(after%modal_mass, 2, 2)
  end function unprojected_errors

  pure real(dp) function rms_of_omitted(amplitude) result(sum_of_others)
    !! Return twice the rms of the sum of all terms beyond the given ones, with random phases.
    real(dp), intent(in) :: amplitude(:)
    real(dp), parameter :: least = 0.01_dp, most = 0.7_dp      ! tuned: ratio of squares per octave
    real(dp) :: last, ratio
    integer :: n
    n = size(amplitude)
    last = sum(amplitude(n/2 + 1:)**2)
    ratio = most
    associate (earlier => sum(amplitude(n/4 + 1:n/2)**2))
      if (earlier > 0.0_dp) ratio = min(most, max(least, last/earlier))
    end associate
    sum_of_others = sqrt(2.0_dp*last*ratio/(1.0_dp - ratio))
  end function rms_of_omitted

end module bw_unprojected
