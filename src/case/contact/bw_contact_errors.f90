module bw_contact_errors
  !! Errors of a motion with a lasting impact. Under given contact forces the truncation error is the contribution of
  !! the omitted modes; that of the next octave is computed (bw_neglected_modes) and extrapolated by its ratio to the
  !! octave before. The rest of the difference to a run with half the modes is an error of contact forces and times,
  !! which depend on omitted modes through the velocity of the struck place, and converges as that does. Mode k responds
  !! as 1/β_k² to the jump of force as a body joins or leaves; then an octave contributes at least an eighth of the
  !! displacement, and half of velocity and moment, of the octave before.
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
  public :: add_rounding, fall_of_force, find_force_errors, find_history_errors, largest_distance

  real(dp), parameter :: of_neglected = 2.0_dp, of_forces = 3.0_dp   !! tuned: safety factors of the two parts;
  real(dp), parameter :: of_half = 2.0_dp  !! tuned: the second is at most so many times its part of the difference
  real(dp), parameter :: in_histories = 2.0_dp, in_forces = 20.0_dp
  !! tuned: step errors over their tolerance: in histories; in forces over the largest and in times over the longest
  !! contact, before contacts amplify them

contains

  pure subroutine find_history_errors(run, half, errors)
    !! Estimate the errors of histories.
    type(run_type), intent(in) :: run, half
    type(history_errors), intent(inout) :: errors
    real(dp) :: fall, octaves, share
    logical :: jumps
    jumps = any(run%timeline%events%kind == arrival_event .or. run%timeline%events%kind == departure_event &
                .or. run%timeline%events%kind == exchange_event)
    octaves = octaves_between(run, half)
    fall = fall_of_force(run, half)**octaves
    share = min(of_half, of_forces*fall)
    associate (mine => run%response, beside => half%response, by => run%neglected, other => half%neglected)
      errors%displacement = error_of(mine%displacement, beside%displacement, by%displacement, other%displacement, 3)
      if (allocated(mine%velocity)) &
        errors%velocity = error_of(mine%velocity, beside%velocity, by%velocity, other%velocity, 1)
      if (allocated(mine%bending_moment)) &
        errors%bending_moment = error_of(mine%bending_moment, beside%bending_moment, by%bending_moment, other%bending_moment, 1)
      if (allocated(mine%acceleration)) &
        errors%acceleration = error_of(mine%acceleration, beside%acceleration, by%acceleration, other%acceleration, 0)
      if (allocated(mine%shear_force)) &
        errors%shear_force = error_of(mine%shear_force, beside%shear_force, by%shear_force, other%shear_force, 0)
    end associate
    call add_step_errors(run, half, errors)
  contains
    pure function error_of(history, fewer, neglected, by_half, power) result(error)
      !! Estimate the error of one quantity. Without further modes it is `of_half` times the difference.
      real(dp), intent(in) :: history(:, :), fewer(:, :)   !! (samples, points)
      real(dp), allocatable, intent(in) :: neglected(:), by_half(:)   !! (points)
      integer, intent(in) :: power                   !! of 1/2, by which octaves fall after a jump of force
      real(dp), dimension(size(history, 2)) :: error, least, ratio
      real(dp), parameter :: most = 0.9_dp, hidden = 0.07_dp   ! tuned
      error = largest_distance(history, fewer)
      least = 0.0_dp
      if (fall >= 1.0_dp) least = error
      if (allocated(neglected) .and. allocated(by_half)) then
        ratio = 1.0_dp
        where (neglected < by_half) ratio = neglected/by_half
        ratio = ratio**(1.0_dp/octaves)
        if (jumps) ratio = max(0.5_dp**power, ratio)
        ratio = min(most, ratio)
        error = of_neglected*neglected/(1.0_dp - ratio) + share*max(hidden*error, error - by_half)
      else
        error = of_half*error
      end if
      error = max(least, error)
    end function error_of
  end subroutine find_history_errors

  pure subroutine add_step_errors(run, half, errors)
    !! Add step errors of histories, as contacts amplify them.
    type(run_type), intent(in) :: run, half
    type(history_errors), intent(inout) :: errors
    real(dp) :: growth
    growth = maxval([1.0_dp, growth_of_steps(run, half)])
    associate (response => run%response)
      errors%displacement = errors%displacement + step_error_in(response%displacement, in_histories)
      if (allocated(response%velocity)) errors%velocity = errors%velocity + step_error_in(response%velocity, in_histories)
      if (allocated(response%bending_moment)) &
        errors%bending_moment = errors%bending_moment + step_error_in(response%bending_moment, in_histories)
      if (allocated(response%acceleration)) &
        errors%acceleration = errors%acceleration + step_error_in(response%acceleration, in_forces)
      if (allocated(response%shear_force)) errors%shear_force = errors%shear_force + step_error_in(response%shear_force, in_forces)
    end associate
  contains
    pure function step_error_in(history, of_tolerance) result(error)
      real(dp), intent(in) :: history(:, :)          !! (samples, points)
      real(dp), intent(in) :: of_tolerance
      real(dp) :: error(size(history, 2))
      error = 0.0_dp
      associate (known => history(:run%response%finite_samples, :))
        where (any(known /= 0.0_dp, dim=1)) error = growth*of_tolerance*run%step_tolerance*largest_magnitude(known)
      end associate
    end function step_error_in
  end subroutine add_step_errors

  pure function growth_of_steps(run, half) result(growth)
    !! Return by how much contacts amplify step errors of the first: as they amplify the difference to half the modes.
    type(run_type), intent(in) :: run, half
    real(dp), allocatable :: growth(:)               !! ≥ 1, (contacts)
    integer, allocatable :: these(:), partner(:)
    real(dp) :: difference, first
    integer :: i
    these = contacts_of(run)
    partner = partners_of(run, half)
    allocate (growth(size(these)), source=1.0_dp)
    associate (force => run%result%force, lacks => run%step_tolerance*largest_magnitude(run%result%force(:, these)))
      first = 2.0_dp*lacks                           ! both runs have step errors
      do i = 1, size(these)
        if (partner(i) == 0) exit
        difference = maxval(abs(force(:, these(i)) - half%result%force(:, partner(i))))
        if (i == 1) first = max(first, difference)
        if (first > 0.0_dp) growth(i:) = max(growth(i), difference/first)
      end do
    end associate
  end function growth_of_steps

  pure subroutine find_force_errors(run, half)
    !! Estimate the errors of contact times and forces. They are unknown for a contact that half of the modes do not
    !! show, and with a single mode, which has no half.
    type(run_type), intent(inout) :: run
    type(run_type), intent(in) :: half
    integer, allocatable :: these(:), partner(:)
    real(dp), allocatable :: grown(:)                ! step errors of forces, over the largest force
    real(dp) :: fall, longest
    integer :: i
    these = contacts_of(run)
    partner = partners_of(run, half)
    associate (events => run%timeline%events, kept => run%result, of_fewer => half%timeline%events)
      kept%force_error = missing
      grown = in_forces*run%step_tolerance*growth_of_steps(run, half)
      longest = maxval([0.0_dp, events(these)%end_time - events(these)%time])
      do i = 1, size(these)
        associate (event => events(these(i)))
          event%time_error = event%time
          event%end_error = event%end_time
          if (partner(i) == 0 .or. run%summed == half%summed) cycle
          fall = 1.0_dp
          if (i <= same_contacts(run, half)) fall = fall_as_struck(run, half)**octaves_between(run, half)
          fall = min(of_half, of_forces*fall)
          event%time_error = fall*abs(event%time - of_fewer(partner(i))%time)
          if (event%time > 0.0_dp) event%time_error = event%time_error + grown(i)*longest
          event%end_error = fall*abs(event%end_time - of_fewer(partner(i))%end_time) + grown(i)*longest
          kept%force_error(these(i)) = fall*maxval(abs(kept%force(:, these(i)) - half%result%force(:, partner(i)))) &
            + grown(i)*largest_magnitude(kept%force(:, these))
        end associate
      end do
      if (size(these) == 0 .or. .not. any(events%kind == capture_event)) return
      i = these(size(these))                         ! it ends at the largest force, which hardly changes
      if (kept%largest(i) /= 0.0_dp .and. .not. is_missing(kept%force_error(i))) events(i)%end_error = &
        max(events(i)%end_error, kept%force_error(i)/abs(kept%largest(i))*(events(i)%end_time - events(i)%time))
      where (events%kind == capture_event)
        events%time_error = events(i)%end_error
        events%end_error = events(i)%end_error
      end where
    end associate
  end subroutine find_force_errors

  pure function contacts_of(run) result(which)
    !! Return the indices of contacts among the events.
    type(run_type), intent(in) :: run
    integer, allocatable :: which(:)
    integer :: i
    associate (kinds => run%timeline%events%kind)
      which = pack([(i, i=1, size(kinds))], kinds == contact_event)
    end associate
  end function contacts_of

  pure real(dp) function fall_of_force(run, half) result(fall)
    !! Return the ratio of force errors per doubling of the modes; 1 if the two runs do not have the same contacts.
    type(run_type), intent(in) :: run, half
    fall = 1.0_dp
    if (same_contacts(run, half) == max(size(contacts_of(run)), size(contacts_of(half)))) fall = fall_as_struck(run, half)
  end function fall_of_force

  pure integer function same_contacts(run, half) result(same)
    !! Count the first contacts that overlap in time in both runs.
    type(run_type), intent(in) :: run, half
    integer, allocatable :: others(:), partner(:)
    others = contacts_of(half)
    partner = partners_of(run, half)
    do same = 0, min(size(partner), size(others)) - 1
      if (partner(same + 1) /= others(same + 1)) return
    end do
  end function same_contacts

  pure function partners_of(run, half) result(partner)
    !! Return for each contact the event of the other run that is the first to overlap with it in time; 0: none.
    type(run_type), intent(in) :: run, half
    integer, allocatable :: partner(:), these(:), others(:)
    integer :: i, j
    these = contacts_of(run)
    others = contacts_of(half)
    allocate (partner(size(these)), source=0)
    j = 1
    do i = 1, size(these)
      associate (one => run%timeline%events(these(i)), beside => half%timeline%events)
        do while (j <= size(others))
          if (beside(others(j))%end_time >= one%time) exit
          j = j + 1
        end do
        if (j > size(others)) exit
        if (beside(others(j))%time > one%end_time) cycle
        partner(i) = others(j)
        j = j + 1
      end associate
    end do
  end function partners_of

  pure real(dp) function fall_as_struck(run, half) result(fall)
    !! Return the ratio, per doubling of the modes, of the velocity that omitted modes contribute at the struck place.
    type(run_type), intent(in) :: run, half
    fall = 1.0_dp
    if (allocated(run%neglected%displacement) .and. run%neglected%struck < half%neglected%struck) &
      fall = (run%neglected%struck/half%neglected%struck)**(1.0_dp/octaves_between(run, half))
  end function fall_as_struck

  pure real(dp) function octaves_between(run, half) result(octaves)
    !! Return the octaves between the mode counts of two runs; 1 for a single mode, which has no half.
    type(run_type), intent(in) :: run, half
    octaves = 1.0_dp
    if (run%summed > half%summed) octaves = log(real(run%summed, dp)/half%summed)/log(2.0_dp)
  end function octaves_between

  pure function largest_distance(table, other) result(distance)
    !! Return the largest difference of two tables in each column, up to the first missing value, (columns that both have).
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
    !! Add the rounding of sums and phases to the errors.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    type(history_errors), intent(inout) :: errors
    real(dp), intent(in), optional :: under_loads(:, :)   !! absent: modes move freely between contacts, (points, quantities)
    if (response%finite_samples == 0) return
    if (present(under_loads)) then
      errors%displacement = errors%displacement + under_loads(:, 1)
      if (allocated(errors%velocity)) errors%velocity = errors%velocity + under_loads(:, 2)
      if (allocated(errors%bending_moment)) errors%bending_moment = errors%bending_moment + under_loads(:, 4)
    else
      associate (rounding => rounding_errors(scene, motion, response, .false.) + drift_errors(scene, motion, deflections, .false.))
        errors%displacement = errors%displacement + rounding
        if (allocated(errors%displacement_bound)) errors%displacement_bound = errors%displacement_bound + rounding
      end associate
      if (allocated(errors%velocity)) errors%velocity = errors%velocity + rounding_errors(scene, motion, response, .true.) &
        + drift_errors(scene, motion, deflections, .true.)
    end if
    if (allocated(errors%acceleration)) errors%acceleration = errors%acceleration + response%acceleration_error
    if (allocated(errors%shear_force)) errors%shear_force = errors%shear_force + response%shear_force_error
  end subroutine add_rounding

end module bw_contact_errors
