module bw_case_moments
  !! Bending moments EI v'' at the points of the histories: sums over the same modes with curvatures in place of shapes.
  !! Curvatures fall two powers of the mode number more slowly than displacements, as velocities do. Their errors are
  !! estimated like those of velocities, and no tolerance applies to them.
  use bw_beam_par, only: has_fibre, second_moment_of, section_at
  use bw_beam_piece, only: fibre_of
  use bw_case_errors, only: errors_of_quantity
  use bw_case_histories, only: sum_histories
  use bw_case_result, only: case_diverged, case_histories, case_motion, history_errors, octave_of
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing, scaled
  use bw_mode_set, only: curvatures
  use bw_monitor, only: monitor_type
  use bw_response, only: response_type
  use bw_scene, only: scene_type
  use bw_text, only: append, shortest
  implicit none (type, external)
  private
  public :: find_moments, scale_of_moments

contains

  subroutine find_moments(scene, motion, monitor, histories, errors)
    !! Add moments to the histories of a case, and their errors to its errors.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout), target :: monitor   !! the moments are invalid if it requests a stop
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors
    type(case_histories) :: found
    call sum_histories(scene, motion, curvatures, monitor, found)
    if (monitor%stop_requested()) return
    if (allocated(errors%displacement)) then
      call errors_of_quantity(scene, motion, curvatures, found, monitor, errors)
      if (monitor%stop_requested()) return
      errors%bending_moment = scaled(errors%bending_moment, scale_of_moments(scene))
    end if
    allocate (histories%response%bending_moment, mold=found%response%displacement)
    histories%response%bending_moment(:, :) = scaled(found%response%displacement, scale_of_moments(scene))
    if (has_fibre(scene%beam)) histories%response%stress_of_moment = stress_of_moment(scene)
    if (allocated(found%blocks)) histories%octave_moment = octave_of(found, size(scene%response%points))*scale_of_moments(scene)
    call fill_overflow(scene, histories%response, errors)
  end subroutine find_moments

  pure real(dp) function scale_of_moments(scene) result(stiffness)
    !! Return EI/l², N, the factor from curvatures in units of displacement, m, to moments, N m.
    type(scene_type), intent(in) :: scene
    stiffness = scene%beam%youngs_modulus*scene%beam%second_moment/scene%beam%length/scene%beam%length
  end function scale_of_moments

  pure function stress_of_moment(scene) result(factor)
    !! Return c/I at the points, m⁻³, the factor from moment to bending stress.
    type(scene_type), intent(in) :: scene
    real(dp) :: factor(size(scene%response%points))
    integer :: p
    do p = 1, size(factor)
      associate (section => section_at(scene%beam, scene%response%points(p)))
        factor(p) = real(fibre_of(section)/second_moment_of(section), dp)
      end associate
    end do
  end function stress_of_moment

  subroutine fill_overflow(scene, response, errors)
    !! Fill the moments from their first overflow on, if it precedes that of displacements, and note it.
    type(scene_type), intent(in) :: scene
    type(response_type), intent(inout) :: response
    type(history_errors), intent(inout) :: errors         !! whose notes and status are those of the case
    integer :: first
    first = findloc(any(is_missing(response%bending_moment), dim=2), .true., dim=1)
    if (first == 0 .or. first > response%finite_samples) return
    response%bending_moment(first:, :) = missing
    errors%status = case_diverged
    call append(errors%notes, 'overflow of the bending moment: it leaves the range of double precision at t = '// &
      shortest((first - 1)*(scene%response%duration/scene%response%samples), 6)//' s; it is missing from there on')
  end subroutine fill_overflow

end module bw_case_moments
