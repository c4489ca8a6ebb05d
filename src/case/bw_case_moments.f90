module bw_case_moments
  !! Bending moments EI v'' at the points of the histories: the same sums over the same modes as those of the displacement, with
  !! curvatures in the place of shapes, and their errors in the same way.
  !!
  !! Amplitudes of curvatures fall two powers of the mode number more slowly than those of displacements, as those of velocities
  !! do: h v'' and v_t are the two parts of one wave function. So the modes that a tolerance leaves out are judged as those of the
  !! velocity are, and no tolerance is promised.
  use bw_case_drift, only: drift_errors
  use bw_case_errors, only: estimate_contacts, missing_motion, rounding_errors
  use bw_case_histories, only: sum_histories
  use bw_case_result, only: case_diverged, case_histories, case_motion, history_errors
  use bw_curvature_set, only: bent_set, bent_source
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing, scaled
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_response, only: response_type
  use bw_scene, only: scene_type
  use bw_text, only: append, shortest
  implicit none (type, external)
  private
  public :: find_moments, sum_moments

contains

  subroutine find_moments(scene, motion, monitor, workspace, histories, errors)
    !! Add the moments to the histories of a case, and their errors to the errors of these.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor         !! the moments mean nothing where it asks to stop
    type(nonuniform_sum), intent(inout) :: workspace
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors
    type(scene_type) :: plain                             ! asks for displacements alone
    type(case_motion) :: bent
    type(case_histories) :: found
    plain = scene
    plain%response%velocity = .false.
    call bend(motion, .false., bent)
    call sum_histories(plain, bent, monitor, workspace, found)
    if (monitor%stop_requested()) return
    if (allocated(errors%displacement)) then
      call find_errors(plain, motion, bent, found%response, monitor, errors%bending_moment)
      errors%bending_moment = scaled(errors%bending_moment, stiffness_of(scene))
    end if
    allocate (histories%response%bending_moment, mold=found%response%displacement)
    histories%response%bending_moment(:, :) = scaled(found%response%displacement, stiffness_of(scene))
    call fill_overflow(scene, histories%response, errors)
  end subroutine find_moments

  subroutine sum_moments(scene, motion, monitor, workspace, moments, first)
    !! The moments alone, of modes from one on, N m, (samples, points).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor         !! the moments mean nothing where it asks to stop
    type(nonuniform_sum), intent(inout) :: workspace
    real(dp), allocatable, intent(out) :: moments(:, :)
    integer, intent(in) :: first
    type(scene_type) :: plain
    type(case_motion) :: bent
    type(case_histories) :: found
    plain = scene
    plain%response%velocity = .false.
    call bend(motion, .false., bent)
    call sum_histories(plain, bent, monitor, workspace, found, first)
    moments = scaled(found%response%displacement, stiffness_of(scene))
  end subroutine sum_moments

  pure real(dp) function stiffness_of(scene) result(stiffness)
    !! EI/l², N: what makes N m of m.
    type(scene_type), intent(in) :: scene
    stiffness = scene%beam%youngs_modulus*scene%beam%second_moment/scene%beam%length/scene%beam%length
  end function stiffness_of

  subroutine fill_overflow(scene, response, errors)
    !! Moments that leave the range of numbers before the displacements do are fill from there on, and a note says so.
    type(scene_type), intent(in) :: scene
    type(response_type), intent(inout) :: response
    type(history_errors), intent(inout) :: errors         !! whose notes and status are those of the case
    integer :: first
    first = findloc(any(is_missing(response%bending_moment), dim=2), .true., dim=1)
    if (first == 0 .or. first > response%finite_samples) return
    response%bending_moment(first:, :) = missing
    errors%status = case_diverged
    call append(errors%notes, 'overflow of the bending moment: it leaves the range of numbers at t = '// &
      shortest((first - 1)*(scene%response%duration/scene%response%samples), 6)//' s; none is given from there on')
  end subroutine fill_overflow

  subroutine find_errors(plain, motion, bent, response, monitor, error)
    !! Estimates of the largest error of the sums of curvatures, m, (points).
    type(scene_type), intent(in) :: plain
    type(case_motion), intent(in) :: motion, bent
    type(response_type), intent(in) :: response           !! of the curvatures
    class(monitor_type), intent(inout), target :: monitor
    real(dp), allocatable, intent(out) :: error(:)
    type(case_motion) :: swinging
    type(history_errors) :: found
    type(part_monitor) :: part
    if (allocated(plain%recontact)) then
      call estimate_contacts(plain, bent, response, found)
      error = found%displacement
      return
    end if
    part = part_monitor(monitor, 1.0_dp, 0.0_dp)
    call bend(motion, .true., swinging)
    error = missing_motion(plain, swinging, .true., part)
    if (allocated(plain%damping)) then                    ! few modes are left then, whose signs count: those of the moment itself
      error = max(error, missing_motion(plain, bent, .false., part))
    end if
    error = error*(abs(plain%impact%approach_velocity)*motion%units%time%hi) + rounding_errors(plain, bent, response, .false.) &
      + drift_errors(plain, bent, .false.)
  end subroutine find_errors

  subroutine bend(motion, scaled, bent)
    !! A motion whose modes are seen through their curvature.
    type(case_motion), intent(in) :: motion
    logical, intent(in) :: scaled                         !! over √λ, see bw_curvature_set
    type(case_motion), intent(out) :: bent
    bent%units = motion%units
    bent%plan = motion%plan
    bent%initial = motion%initial
    bent%modes%can_grow = motion%modes%can_grow
    bent%modes%resolved = motion%modes%resolved
    call bent_set(motion%modes%free, scaled, bent%modes%free)
    call bent_set(motion%modes%loaded, scaled, bent%modes%loaded)
    call bent_source(motion%sources%free, scaled, bent%sources%free)
    call bent_source(motion%sources%loaded, scaled, bent%sources%loaded)
    bent%later%known_until = motion%later%known_until
    bent%later%ending = motion%later%ending
    if (allocated(motion%later%segments)) bent%later%segments = motion%later%segments
    call bent_set(motion%later%in_contact, scaled, bent%later%in_contact)
    call bent_set(motion%later%released, scaled, bent%later%released)
  end subroutine bend

end module bw_case_moments
