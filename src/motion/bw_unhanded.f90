module bw_unhanded
  !! What the modes after a change may be off by, as only so many modes before it hand on their motion. Those beyond, k, are far above the
  !! modes after that matter, j: what each of them hands on is a blow (m − k_v/β_k²)Φ̄_jΦ_kq̇_k of a body that comes or leaves, with
  !! mass m and stiffness k_v, and likewise of its turning. Their phases are as good as random by then. So their squares add up, and fall
  !! on from octave to octave as those of the last two that are known do. Runs with fewer modes do not tell this: where phases happen to
  !! cancel, they agree, and all of them are wrong.
  !!
  !! A mass with a velocity of its own takes none of the beam's, but what it is deflected by. Springs that come are unstressed at a
  !! deflection that lacks the missing modes. **Limit**: the tension that comes or leaves with a body is left out; it is less by 1/β_k².
  !! Units of bw_segment.
  use bw_change_of_bodies, only: body_type
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: unhanded_motion

contains

  pure function unhanded_motion(before, q, rate, after, bodies, was, is) result(doubt)
    !! Of modal displacements and velocities after the change, twice their root mean square, (modes after, 2).
    class(mode_set), intent(in) :: before, after
    real(dp), intent(in) :: q(:), rate(:)          !! of the modes before that hand on their motion
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: was(:), is(:)           !! which of them are there before and after, (bodies)
    real(dp) :: doubt(after%count, 2)
    real(dp) :: inert(2), elastic(2), seen(before%count, 2), shape(after%count, 2), blow(size(q)), reach(size(q))
    logical :: brings                              ! a velocity of its own
    real(dp), parameter :: lowest = 1.0_dp          ! β² below that is of rigid modes, which no spring bends
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
          if (.not. brings) doubt(:, 2) = doubt(:, 2) + shape(:, c)*beyond(blow)
          doubt(:, 1) = doubt(:, 1) + shape(:, c)*beyond(blow/sqrt(square))
          if (is(b)) doubt(:, 1) = doubt(:, 1) + shape(:, c)*elastic(c)/square_after &
            *beyond(abs(seen(:size(q), c))*reach/sqrt(square))
        end do
      end do
    end associate
    doubt = doubt/spread(after%modal_mass, 2, 2)
  end function unhanded_motion

  pure real(dp) function beyond(amplitude) result(sum_of_others)
    !! Twice the root mean square of the sum of all terms beyond these, whose phases are random.
    real(dp), intent(in) :: amplitude(:)
    real(dp), parameter :: least = 0.01_dp, most = 0.7_dp      ! tuned: of squares, from octave to octave
    real(dp) :: last, ratio
    integer :: n
    n = size(amplitude)
    last = sum(amplitude(n/2 + 1:)**2)
    ratio = most
    associate (earlier => sum(amplitude(n/4 + 1:n/2)**2))
      if (earlier > 0.0_dp) ratio = min(most, max(least, last/earlier))
    end associate
    sum_of_others = sqrt(2.0_dp*last*ratio/(1.0_dp - ratio))
  end function beyond

end module bw_unhanded
