module bw_let_go_errors
  !! Errors of the histories of a beam that is let go from a static deflection. The amplitude of every mode is known,
  !! q_k = FΦ_k(ξ_F)/(M_kβ_k²), and none moves farther than at first nor faster than β_kq_k. All begin in phase, and so moments
  !! have an error of the sum of their magnitudes; velocities have the part of that sum that the last modes reach of theirs.
  use bw_beam_units, only: beam_units
  use bw_case_bodies, only: beam_of
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_motion, history_errors
  use bw_kinds, only: dp
  use bw_mode_set, only: curvatures, deflections, mode_set, values_at
  use bw_scene, only: scene_type
  use bw_static_shape, only: deflection, static_shapes
  use bw_timeline, only: configurations_of
  implicit none (type, external)
  private
  public :: find_let_go_errors

contains

  subroutine find_let_go_errors(scene, motion, fewer, errors)
    !! Bound displacements, and estimate the errors of the other quantities, without rounding.
    type(scene_type), intent(in) :: scene          !! see `is_let_go`, with a response
    type(case_motion), intent(in) :: motion        !! more modes are known than are summed, if there are that many
    integer, intent(in) :: fewer                   !! modes
    type(history_errors), intent(inout) :: errors  !! enter as the largest differences from the histories of fewer modes
    real(dp), dimension(size(scene%response%points)) :: omitted, part
    real(dp), allocatable :: amplitude(:)
    associate (modes => motion%modes%configuration(1)%set, segment => motion%timeline%segments(1), response => scene%response)
      errors%displacement_bound = bound_of_omitted(scene, motion%units, modes, segment%count)
      errors%displacement = errors%displacement_bound
      amplitude = abs(segment%q)
      if (response%bending_moment) then
        call sum_magnitudes(modes, curvatures, amplitude, [fewer, segment%count], response%points, part, omitted)
        errors%bending_moment = motion%units%time%hi*scale_of_moments(scene)*omitted
      end if
      if (.not. response%velocity) return
      amplitude = amplitude*sqrt(modes%beta_squared%hi)
      call sum_magnitudes(modes, deflections, amplitude, [fewer, segment%count], response%points, part, omitted)
      errors%velocity = omitted*merge(2.0_dp*errors%velocity/part, 1.0_dp, 2.0_dp*errors%velocity < part)
    end associate
  end subroutine find_let_go_errors

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
