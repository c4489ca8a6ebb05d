module bw_let_go_errors
  !! Errors of the histories of a beam that is let go from a static deflection. The amplitude of every mode is known,
  !! q_k = FΦ_k(ξ_F)/(M_kβ_k²), and none moves farther than at first nor faster than β_kq_k.
  use bw_beam_units, only: beam_units
  use bw_case_bodies, only: beam_of
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_motion, history_errors
  use bw_kinds, only: dp
  use bw_load_modes, only: find_residuals
  use bw_mode_set, only: curvatures, deflections, mode_set, values_at
  use bw_scene, only: scene_type
  use bw_timeline, only: configurations_of
  implicit none (type, external)
  private
  public :: find_let_go_errors

contains

  subroutine find_let_go_errors(scene, motion, errors)
    !! Bound displacements, and estimate the errors of the other quantities, without rounding.
    type(scene_type), intent(in) :: scene          !! see `is_let_go`, with a response
    type(case_motion), intent(in) :: motion        !! more modes are known than are summed, if there are that many
    type(history_errors), intent(inout) :: errors
    associate (modes => motion%modes%configuration(1)%set, segment => motion%timeline%segments(1), response => scene%response)
      errors%displacement_bound = bound_of_omitted(scene, motion%units, modes, segment%count)
      errors%displacement = errors%displacement_bound
      associate (rate => abs(segment%q)*sqrt(modes%beta_squared%hi))
        if (response%velocity) errors%velocity = sum_of_omitted(modes, deflections, rate, segment%count, response%points)
      end associate
      if (response%bending_moment) errors%bending_moment = motion%units%time%hi*scale_of_moments(scene) &
        *sum_of_omitted(modes, curvatures, abs(segment%q), segment%count, response%points)
    end associate
  end subroutine find_let_go_errors

  function bound_of_omitted(scene, units, modes, summed) result(bound)
    !! Bound the displacements of omitted modes, m, (points): F Σ|Φ_k(ξ)Φ_k(ξ_F)|/(M_kβ_k²) ≤ F √(r(ξ)r(ξ_F)), with their
    !! flexibility r.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed
    real(dp) :: bound(size(scene%response%points))
    real(dp), dimension(1, size(bound), 1) :: residual, terms
    real(dp) :: flexibility(size(bound) + 1), weights(modes%count, size(bound), 1)
    associate (place => [scene%initial%position], points => scene%response%points, carried => configurations_of(scene))
      weights(:, :, 1) = modes%some_shapes(1, modes%count, points)
      call find_residuals(beam_of(scene, units, carried(1)), modes, summed, place, .false., &
                          modes%some_shapes(1, modes%count, place), weights, points, residual, terms, flexibility)
      bound = abs(scene%initial%force)*units%time%hi**2/units%mass*sqrt(flexibility(:size(points))*flexibility(size(flexibility)))
    end associate
  end function bound_of_omitted

  function sum_of_omitted(modes, quantity, amplitude, summed, points) result(omitted)
    !! Sum the magnitudes of omitted modes: those that are known, and all later octaves as a geometric series, (points).
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: quantity, summed
    real(dp), intent(in) :: amplitude(:)           !! of all known modes
    real(dp), intent(in) :: points(:)              !! ξ
    real(dp) :: omitted(size(points))
    real(dp), parameter :: least = 0.5_dp, most = 0.8_dp   ! of octaves of k^-2, and of those that fall more slowly for a while
    real(dp) :: terms(size(amplitude), size(points)), last, ratio
    integer :: n, p
    n = size(amplitude)
    terms = spread(amplitude, 2, size(points))*abs(values_at(modes, quantity, 1, n, points))
    do p = 1, size(points)
      last = sum(terms(n/2 + 1:, p))
      ratio = most
      associate (earlier => sum(terms(n/4 + 1:n/2, p)))
        if (earlier > 0.0_dp) ratio = min(most, max(least, last/earlier))
      end associate
      omitted(p) = sum(terms(summed + 1:, p)) + last*ratio/(1.0_dp - ratio)
    end do
  end function sum_of_omitted

end module bw_let_go_errors
