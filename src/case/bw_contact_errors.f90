module bw_contact_errors
  !! Errors of a motion whose impact lasts, from three ways to follow it, with n, n/2 and n/4 modes. Where ρ is the ratio of what the last
  !! two steps change, what is left is about ρ/(1 − ρ) of the last change; three times that is given, since ρ need not stay the same.
  use bw_case_contacts, only: run_type
  use bw_case_drift, only: drift_errors, rounding_errors
  use bw_case_result, only: case_motion, history_errors
  use bw_event, only: arrival_event, capture_event, contact_event, departure_event, exchange_event
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing, missing
  use bw_mode_set, only: deflections
  use bw_response, only: response_type
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: add_rounding, find_force_errors, find_history_errors, largest_distance, part_of_peak

  real(dp), parameter :: in_histories = 0.3_dp, in_forces = 20.0_dp   !! tuned: of their tolerance, what steps leave

contains

  pure subroutine find_history_errors(run, half, quarter, resolved, errors)
    !! Of histories.
    type(run_type), intent(in) :: run, half, quarter
    logical, intent(in) :: resolved                  !! the modes move through some periods within the first contact
    type(history_errors), intent(inout) :: errors
    associate (response => run%response, beside => half%response, further => quarter%response, &
               left => in_histories*run%step_tolerance, least => least_ratio(run, half, quarter, resolved))
      errors%displacement = error_of(response%displacement, beside%displacement, further%displacement, left, least)
      if (allocated(response%velocity)) errors%velocity = &
        error_of(response%velocity, beside%velocity, further%velocity, left, least)
      if (allocated(response%bending_moment)) errors%bending_moment = &
        error_of(response%bending_moment, beside%bending_moment, further%bending_moment, left, least)
      if (allocated(response%acceleration)) errors%acceleration = &
        error_of(response%acceleration, beside%acceleration, further%acceleration, left, least)
      if (allocated(response%shear_force)) errors%shear_force = &
        error_of(response%shear_force, beside%shear_force, further%shear_force, left, least)
    end associate
  end subroutine find_history_errors

  pure subroutine find_force_errors(run, half, quarter, resolved)
    !! Of contacts: their times and their forces. A contact that half of the modes do not show is not known at all.
    type(run_type), intent(inout) :: run
    type(run_type), intent(in) :: half, quarter
    logical, intent(in) :: resolved                  !! as that of `find_history_errors`
    real(dp) :: least
    integer, allocatable :: these(:), of_half(:), of_quarter(:)   ! events that are contacts
    integer :: i, known
    least = least_ratio(run, half, quarter, resolved)
    these = contacts_of(run)
    of_half = contacts_of(half)
    of_quarter = contacts_of(quarter)
    known = min(size(these), size(of_half))
    associate (events => run%timeline%events, kept => run%result, first => these(:known))
      kept%force_error = missing
      kept%force_error(first) = error_of(kept%force(:, first), half%result%force(:, of_half), quarter%result%force(:, of_quarter), &
                                         in_forces*run%step_tolerance, least)
      events(first)%time_error = error_of(one_row(events(these)%time), one_row(half%timeline%events(of_half)%time), &
                                          one_row(quarter%timeline%events(of_quarter)%time), 0.0_dp, least)
      events(first)%end_error = error_of(one_row(events(these)%end_time), one_row(half%timeline%events(of_half)%end_time), &
                                         one_row(quarter%timeline%events(of_quarter)%end_time), 0.0_dp, least)
      do i = known + 1, size(these)
        events(these(i))%time_error = events(these(i))%time
        events(these(i))%end_error = events(these(i))%end_time
      end do
      if (size(these) == 0) return
      where (events%kind == capture_event) events%time_error = events(these(size(these)))%end_error
    end associate
  contains
    pure function one_row(times) result(row)
      real(dp), intent(in) :: times(:)
      real(dp) :: row(1, known)
      integer :: k
      row = missing
      k = min(known, size(times))
      row(1, :k) = times(:k)
    end function one_row
  end subroutine find_force_errors

  pure function contacts_of(run) result(which)
    !! Of its events.
    type(run_type), intent(in) :: run
    integer, allocatable :: which(:)
    integer :: i
    associate (kinds => run%timeline%events%kind)
      which = pack([(i, i=1, size(kinds))], kinds == contact_event)
    end associate
  end function contacts_of

  pure real(dp) function least_ratio(run, half, quarter, resolved) result(least)
    !! Of what the last two steps change, as far as it is believed. How errors fall says little where modes hardly move within a contact,
    !! or where one of the motions has contacts that another has not.
    type(run_type), intent(in) :: run, half, quarter
    logical, intent(in) :: resolved
    real(dp), parameter :: usual = 0.1_dp, loaded = 0.35_dp, doubtful = 0.5_dp   ! tuned
    least = usual
    if (lets_go(run)) least = loaded
    if (any(run%timeline%events%kind == arrival_event .or. run%timeline%events%kind == departure_event .or. &
            run%timeline%events%kind == exchange_event)) least = doubtful
    if (.not. resolved .or. size(run%timeline%events) /= size(half%timeline%events) .or. &
        size(half%timeline%events) /= size(quarter%timeline%events)) least = doubtful
  end function least_ratio

  pure logical function lets_go(run)
    !! Something that bends the beam ends at once, which modes beyond answer as they please: loads may, a deflection that is let go does, and
    !! so does the force of a contact whose mass is captured.
    type(run_type), intent(in) :: run
    associate (timeline => run%timeline)
      lets_go = allocated(run%rounding) .or. any(timeline%events%kind == capture_event)
      if (size(timeline%segments) > 0) lets_go = lets_go .or. any(timeline%segments(1)%q /= 0.0_dp)
    end associate
  end function lets_go

  pure function error_of(values, beside, further, left, least) result(error)
    !! Of the columns of a table. The coarser ones may have fewer or more of them.
    real(dp), intent(in) :: values(:, :), beside(:, :), further(:, :)
    real(dp), intent(in) :: left                     !! by steps, of the largest value
    real(dp), intent(in) :: least                    !! ratio of the last two steps
    real(dp) :: error(size(values, 2))
    real(dp), parameter :: most = 0.9_dp             ! tuned
    real(dp), parameter :: times = 3.0_dp            ! tuned
    real(dp), parameter :: shared = 0.01_dp          ! tuned: of the largest error of any column, that every column may have
    real(dp), allocatable :: before(:)
    real(dp) :: ratio(size(values, 2))
    integer :: known
    error = largest_distance(values, beside)
    before = largest_distance(beside, further)
    known = min(size(error), size(before))
    if (any(before > 0.0_dp)) then
      ratio = maxval(error)/maxval(before)
      where (before(:known) > 0.0_dp) ratio(:known) = max(ratio(:known), error(:known)/before(:known))
      ratio = min(most, max(least, ratio))
      error = error*(times*ratio/(1.0_dp - ratio))
    end if
    where (error > 0.0_dp) error = max(error, shared*maxval(error))
    if (left > 0.0_dp) error = error + left*largest_magnitude(values)
  end function error_of

  pure function largest_distance(table, other) result(distance)
    !! Between two tables, where both are known, (columns that both have).
    real(dp), intent(in) :: table(:, :), other(:, :)   !! (rows, columns)
    real(dp) :: distance(min(size(table, 2), size(other, 2)))
    integer :: j, p
    distance = 0.0_dp
    do p = 1, size(distance)
      do j = 1, size(table, 1)
        if (is_missing(table(j, p)) .or. is_missing(other(j, p))) exit
        distance(p) = max(distance(p), abs(table(j, p) - other(j, p)))
      end do
    end do
  end function largest_distance

  subroutine add_rounding(scene, motion, response, errors, under_loads)
    !! What rounding leaves of sums and of phases.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    type(history_errors), intent(inout) :: errors
    real(dp), intent(in), optional :: under_loads(:, :)   !! absent: the modes move freely between contacts, (points, quantities)
    if (response%finite_samples == 0) return
    if (present(under_loads)) then
      errors%displacement = errors%displacement + under_loads(:, 1)
      if (allocated(errors%velocity)) errors%velocity = errors%velocity + under_loads(:, 2)
      if (allocated(errors%bending_moment)) errors%bending_moment = errors%bending_moment + under_loads(:, 4)
    else
      associate (of_sums => rounding_errors(scene, motion, response, .false.))
        errors%displacement = errors%displacement + of_sums + drift_errors(scene, motion, deflections, .false.)
      end associate
      if (allocated(errors%velocity)) errors%velocity = errors%velocity + rounding_errors(scene, motion, response, .true.) &
        + drift_errors(scene, motion, deflections, .true.)
    end if
    if (allocated(errors%acceleration)) errors%acceleration = errors%acceleration + response%acceleration_error
    if (allocated(errors%shear_force)) errors%shear_force = errors%shear_force + response%shear_force_error
  end subroutine add_rounding

  pure real(dp) function part_of_peak(response, errors) result(part)
    !! The largest error of a quantity over its peak.
    type(response_type), intent(in) :: response
    type(history_errors), intent(in) :: errors
    integer :: n
    n = response%finite_samples
    part = 0.0_dp
    if (n == 0) return
    call look(response%displacement, errors%displacement)
    if (allocated(response%velocity)) call look(response%velocity, errors%velocity)
    if (allocated(response%bending_moment)) call look(response%bending_moment, errors%bending_moment)
    if (allocated(response%acceleration)) call look(response%acceleration, errors%acceleration)
    if (allocated(response%shear_force)) call look(response%shear_force, errors%shear_force)
  contains
    pure subroutine look(history, error)
      real(dp), intent(in) :: history(:, :), error(:)
      real(dp) :: peak
      peak = largest_magnitude(history(:n, :))
      if (maxval(error) > 0.0_dp .and. peak > 0.0_dp) part = max(part, maxval(error)/peak)
    end subroutine look
  end function part_of_peak

end module bw_contact_errors
