module bw_reached_tolerance
  !! A tolerance whose number of modes the run finds: the counts to begin with, and whether it is met, missed, or relaxed if it
  !! is the default. Counts that are given are always enough.
  use bw_case_result, only: case_done, case_not_converged, history_errors
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing, missing
  use bw_modes_par, only: by_tolerance, modes_par, relaxed_tolerance
  use bw_note, only: remark
  use bw_response, only: response_type
  use bw_scene, only: scene_type
  use bw_text, only: append, shortest, text_of
  implicit none (type, external)
  private
  public :: is_met, judge_tolerance, part_of_peak, with_counts

  integer, parameter, public :: first_count = 32   !! modes that a run with a tolerance begins with

contains

  pure type(scene_type) function with_counts(scene, count) result(counted)
    !! Return a scene with counts: those given, or with a tolerance those that its run begins with.
    type(scene_type), intent(in) :: scene
    integer, intent(in), optional :: count           !! with a tolerance; absent: `first_count`
    counted = scene
    if (.not. by_tolerance(scene%modes)) return
    counted%modes%tolerance = missing
    counted%modes%before = first_count
    if (present(count)) counted%modes%before = count
    counted%modes%after = counted%modes%before
  end function with_counts

  pure logical function is_met(modes, reached)
    !! Return whether no more modes are needed.
    type(modes_par), intent(in) :: modes
    real(dp), intent(in) :: reached                  !! largest error over its peak
    is_met = .not. by_tolerance(modes) .or. reached <= modes%tolerance
  end function is_met

  subroutine judge_tolerance(modes, reached, count, instead, response, errors)
    !! Note a tolerance that is not met, and set the status if it is missed.
    type(modes_par), intent(in) :: modes
    real(dp), intent(in) :: reached                  !! largest error over its peak
    integer, intent(in) :: count                     !! modes summed
    character(*), intent(in) :: instead              !! what else would give histories
    type(response_type), allocatable, intent(in) :: response
    type(history_errors), intent(inout) :: errors
    character(*), parameter :: name(*) = [character(14) :: 'displacement', 'velocity', 'bending moment', 'acceleration', &
                                          'shear force']
    if (errors%status /= case_done .or. is_met(modes, reached)) return
    if (modes%asked) then
      errors%status = case_not_converged
      call append(errors%notes, 'tolerance: '//shortest(modes%tolerance, 6)//' is not met with '//text_of(count)// &
                  ' modes; accepted: '//shortest(1.05_dp*reached, 2)//' or more, or before = '//text_of(count))
    else if (is_missing(relaxed_tolerance(reached))) then
      errors%status = case_not_converged
      call append(errors%notes, 'tolerance: none can be met with '//text_of(count)//' modes; accepted: '//instead// &
                  ', or before = '//text_of(count))
    else
      call remark(errors%notes, 'tolerance: relaxed for the histories to '//shortest(relaxed_tolerance(reached), 6)// &
                  ' of their peaks, the '//trim(name(maxloc(parts_of_peak(response, errors), dim=1)))// &
                  ' being least accurate; the default '//shortest(modes%tolerance, 6)//' is out of reach')
    end if
  end subroutine judge_tolerance

  pure real(dp) function part_of_peak(response, errors) result(part)
    !! Return the largest error of any quantity over its peak.
    type(response_type), intent(in) :: response
    type(history_errors), intent(in) :: errors
    part = maxval(parts_of_peak(response, errors))
  end function part_of_peak

  pure function parts_of_peak(response, errors) result(part)
    !! Return these ratios for displacement, velocity, bending moment, acceleration and shear force.
    type(response_type), intent(in) :: response
    type(history_errors), intent(in) :: errors
    real(dp) :: part(5)
    part = 0.0_dp
    if (response%finite_samples == 0) return
    part(1) = of_peak(response%displacement, errors%displacement)
    if (allocated(response%velocity)) part(2) = of_peak(response%velocity, errors%velocity)
    if (allocated(response%bending_moment)) part(3) = of_peak(response%bending_moment, errors%bending_moment)
    if (allocated(response%acceleration)) part(4) = of_peak(response%acceleration, errors%acceleration)
    if (allocated(response%shear_force)) part(5) = of_peak(response%shear_force, errors%shear_force)
  contains
    pure real(dp) function of_peak(history, error)
      real(dp), intent(in) :: history(:, :), error(:)
      real(dp) :: peak
      peak = largest_magnitude(history(:response%finite_samples, :))
      of_peak = 0.0_dp
      if (maxval(error) > 0.0_dp .and. peak > 0.0_dp) of_peak = maxval(error)/peak
    end function of_peak
  end function parts_of_peak

end module bw_reached_tolerance
