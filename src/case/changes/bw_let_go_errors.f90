module bw_let_go_errors
  !! Errors of the histories of a beam that is let go from a static deflection. The amplitude of every mode is known,
  !! q_k = FΦ_k(ξ_F)/(M_kβ_k²), and none moves farther than at first nor faster than β_kq_k. All begin in phase, and so moments
  !! have an error of the sum of their magnitudes; velocities have the part of that sum that the last modes reach of theirs.
  !! **Limit**: only the bound includes a local mode far above those that are known, such as that of a stiff piece at the tip.
  use bw_beam_motion, only: case_modes
  use bw_beam_units, only: beam_units
  use bw_case_bodies, only: beam_of
  use bw_case_modes, only: case_mode_cache, find_modes
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_motion, history_errors
  use bw_kinds, only: dp
  use bw_mode_set, only: curvatures, deflections, mode_set, values_at
  use bw_monitor, only: monitor_type
  use bw_scene, only: scene_type
  use bw_static_shape, only: deflection, static_shapes
  use bw_timeline, only: configurations_of
  implicit none (type, external)
  private
  public :: find_let_go_errors

  integer, parameter :: known = 256                !! modes that show how amplitudes fall, if fewer are summed

contains

  subroutine find_let_go_errors(scene, motion, fewer, monitor, cache, errors)
    !! Bound displacements, and estimate the errors of the other quantities, without rounding.
    type(scene_type), intent(in) :: scene          !! see `is_let_go`, with mode counts and a response
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: fewer                   !! modes
    class(monitor_type), intent(inout), target :: monitor   !! errors are invalid if it requests a stop
    type(case_mode_cache), intent(inout), target :: cache
    type(history_errors), intent(inout) :: errors  !! enter as the largest differences from the histories of fewer modes
    type(scene_type) :: more
    type(case_modes) :: modes
    modes = motion%modes
    associate (summed => motion%timeline%segments(1)%count, force => abs(scene%initial%force)/motion%units%mass)
      errors%displacement_bound = bound_of_omitted(scene, motion%units, modes%configuration(1)%set, summed)
      errors%displacement = errors%displacement_bound
      more = scene
      more%modes%before = min(4*summed, known)
      more%modes%after = more%modes%before
      if (more%modes%before >= 2*summed) call find_modes(more, motion%units, monitor, modes, cache)
      if (monitor%stop_requested()) return
      if (.not. modes%resolved) modes = motion%modes
      call find_others(scene, motion%units, modes%configuration(1)%set, force, [fewer, summed], errors)
    end associate
  end subroutine find_let_go_errors

  subroutine find_others(scene, units, modes, force, summed, errors)
    !! Estimate the errors of velocities and moments.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes           !! more than are summed
    real(dp), intent(in) :: force                  !! over the mass of the beam, m/s²
    integer, intent(in) :: summed(2)               !! fewer modes, and all
    type(history_errors), intent(inout) :: errors
    real(dp), dimension(size(scene%response%points)) :: omitted, part
    real(dp) :: shape(modes%count, 1)
    shape = abs(modes%some_shapes(1, modes%count, [scene%initial%position]))
    associate (response => scene%response, square => modes%beta_squared%hi)
      if (response%bending_moment) then
        call sum_magnitudes(modes, curvatures, shape(:, 1)/(modes%modal_mass*square), summed, response%points, part, omitted)
        errors%bending_moment = force*units%time%hi**2*scale_of_moments(scene)*omitted
      end if
      if (.not. response%velocity) return
      call sum_magnitudes(modes, deflections, shape(:, 1)/(modes%modal_mass*sqrt(square)), summed, response%points, part, omitted)
      associate (velocity => force*units%time%hi, reached => 2.0_dp*errors%velocity)
        where (reached < velocity*part) omitted = omitted*(reached/(velocity*part))
        errors%velocity = velocity*omitted
      end associate
    end associate
  end subroutine find_others

  function bound_of_omitted(scene, units, modes, summed) result(bound)
    !! Bound the displacements of omitted modes, m, (points): F Σ|Φ_k(ξ)Φ_k(ξ_F)|/(M_kβ_k²) ≤ F √(r(ξ)r(ξ_F)), with their
    !! flexibility r, that of the beam less that of the summed modes.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed
    real(dp) :: bound(size(scene%response%points))
    real(dp), parameter :: rounding = 1.0e-13_dp   ! of the static solution
    real(dp), dimension(size(bound) + 1) :: place, flexibility
    real(dp), allocatable :: whole(:, :, :)
    integer :: p
    place = [scene%response%points, scene%initial%position]
    associate (carried => configurations_of(scene))
      whole = static_shapes(beam_of(scene, units, carried(1)), place, .false., 0.0_dp, place)
    end associate
    flexibility = [(whole(p, deflection, p), p=1, size(place))]
    flexibility = max(0.0_dp, flexibility - matmul(1.0_dp/(modes%modal_mass(:summed)*modes%beta_squared(:summed)%hi), &
                                                   modes%some_shapes(1, summed, place)**2)) + rounding*flexibility
    bound = abs(scene%initial%force)*units%time%hi**2/units%mass*sqrt(flexibility(:size(bound))*flexibility(size(place)))
  end function bound_of_omitted

  subroutine sum_magnitudes(modes, quantity, amplitude, summed, points, part, omitted)
    !! Sum the magnitudes of the last summed modes, and of all omitted ones: the known, and later octaves as a geometric series.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: quantity
    real(dp), intent(in) :: amplitude(:)           !! of all known modes
    integer, intent(in) :: summed(2)               !! fewer modes, and all
    real(dp), intent(in) :: points(:)              !! ξ
    real(dp), intent(out) :: part(:)               !! of the modes between these, (points)
    real(dp), intent(out) :: omitted(:)            !! of the modes behind them, (points)
    real(dp), parameter :: least = 0.5_dp, most = 0.8_dp   ! of octaves of k^-2, and of those that fall more slowly for a while
    real(dp) :: terms(size(amplitude), size(points))
    real(dp), dimension(size(points)) :: earlier, last, ratio
    integer :: n
    n = size(amplitude)
    terms = spread(amplitude, 2, size(points))*abs(values_at(modes, quantity, 1, n, points))
    earlier = sum(terms(n/4 + 1:n/2, :), dim=1)
    last = sum(terms(n/2 + 1:, :), dim=1)
    ratio = most
    where (most*earlier > last) ratio = max(least, last/earlier)
    part = sum(terms(summed(1) + 1:summed(2), :), dim=1)
    omitted = sum(terms(summed(2) + 1:, :), dim=1) + last*ratio/(1.0_dp - ratio)
  end subroutine sum_magnitudes

end module bw_let_go_errors
