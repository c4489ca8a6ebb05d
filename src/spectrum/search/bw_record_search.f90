module bw_record_search
  !! The search of a whole record for blows and lines. Where the first search rests on an assumption that may fail, another begins
  !! without it, and the one with the lower J is kept: a record may begin within a decay, and a blow may last.
  use bw_blow_contact, only: beginnings, leave_out_contact, may_last, most_left_out, shorten_contact
  use bw_blows, only: find_blows
  use bw_cost, only: cost_of_all, penalty_of_line
  use bw_kinds, only: dp
  use bw_limited_range, only: allow_for_limits
  use bw_line_drops, only: drop_lines, line_outcome
  use bw_line_search, only: find_lines_after, improve_lines, many_lines
  use bw_model, only: model_type
  use bw_monitor, only: monitor_type, part_monitor, stops
  use bw_samples, only: gaps_of, gaps_type, part_of, samples_type, validity
  use bw_search_state, only: go_back, keep_if_cheaper, refit_in_new_noise, state_of, state_type
  use bw_stretches, only: add_blow, shift_blow
  implicit none (type, external)
  private
  public :: find_lines

  integer, parameter, public :: searched_first = 2**21    !! tuned: numbers at all sensors of the part that is searched first

contains

  subroutine find_lines(samples, false_alarm, model, outcome, monitor)
    !! Find the lines of a record.
    type(samples_type), intent(inout) :: samples   !! samples of a contact are marked as missing
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(out) :: model
    type(line_outcome), intent(out) :: outcome
    class(monitor_type), intent(inout), optional, target :: monitor  !! results are undefined after a stop request
    integer, allocatable :: blows(:)
    real(dp), allocatable :: recorded(:, :)
    integer :: dropped
    if (allocated(samples%blow)) then
      blows = samples%blow
    else
      call find_blows(samples, false_alarm, blows)
    end if
    call begin_with_part(min(samples%count, blows(1) - 1 + searched_first/size(samples%value, 2)))
    if (.not. allocated(model%lines)) call find_lines_after(blows, samples, false_alarm, model, outcome, monitor)
    if (stops(monitor)) return
    if (outcome%driven .and. allocated(samples%missing) .and. size(blows) > 1 .and. .not. allocated(samples%blow)) &
      & call find_lines_after(blows(:1), samples, false_alarm, model, outcome, monitor)    ! gaps may look like further blows
    if (outcome%converged .and. .not. (allocated(samples%blow) .or. allocated(samples%place)) .and. blows(1) > 1 &
      & .and. (outcome%driven .or. any(model%lines%steady))) call try_earlier_blow()
    if (allocated(samples%place) .and. .not. allocated(samples%blow)) call move_uneven_blow()
    if (.not. allocated(samples%blow) .and. size(model%lines) <= many_lines) call try_contact()
    call allow_for_limits(samples, model, recorded, monitor)
    do while (allocated(recorded))               ! lines of the truncated noise gain nothing now
      call drop_lines(samples, false_alarm, model, dropped, monitor)
      if (dropped == 0) exit
      if (stops(monitor)) exit
      call allow_for_limits(samples, model, recorded, monitor)
    end do
    if (allocated(recorded)) call move_alloc(recorded, samples%value)

  contains

    subroutine begin_with_part(last)
      !! Find lines in the first part of a long record, and follow them through the whole. What the part does not show is added
      !! there.
      integer, intent(in) :: last                  !! sample of the part
      type(part_monitor), allocatable :: begun
      type(model_type) :: part
      if (last > samples%count/2) return
      if (present(monitor)) begun = part_monitor(monitor, share=0.5_dp)
      call find_lines_after(pack(blows, blows <= last), part_of(samples, 1, last), false_alarm, part, outcome, begun)
      if (size(part%lines) == 0) return
      deallocate (part%white)                      ! a record may fill the memory
      call find_lines_after([part%stretches(1, 1:), pack(blows, blows > last)], samples, false_alarm, model, outcome, monitor, part)
    end subroutine begin_with_part

    subroutine move_uneven_blow()
      !! Move the blow to earlier samples as long as J falls: interpolated at even times it is seen too late.
      type(state_type) :: before
      integer :: moved
      do while (model%stretches(1, 1) > 1 .and. any(.not. model%lines%steady))
        before = state_of(samples, false_alarm, model)
        call shift_blow(model, 1, model%stretches(1, 1) - 1)
        moved = 1
        call keep_if_cheaper(samples, false_alarm, before, model, moved)
        if (moved == 0) exit
        if (stops(monitor)) exit
      end do
    end subroutine move_uneven_blow

    subroutine try_contact()
      !! Leave out the samples of a contact if J is lower, or if there are lines only without them.
      type(state_type) :: before, best
      type(line_outcome) :: with_contact
      type(gaps_type) :: missing(size(samples%value, 2))
      real(dp) :: cost
      integer, allocatable :: first(:)
      integer :: length, s
      before = state_of(samples, false_alarm, model)
      first = beginnings(before%stretches(1, 1:))
      length = most_left_out(first, samples%count)
      if (length == 0) return
      if (outcome%driven) then
        if (.not. decays_without(first, length)) return
      else
        if (all(model%lines%steady) .or. .not. may_last(false_alarm, model)) return
      end if
      with_contact = outcome
      do s = 1, size(missing)
        missing(s) = gaps_of(validity(samples, s))
      end do
      call leave_out_contact(missing, first, length, samples, model)
      if (outcome%driven .or. size(first) < ubound(before%stretches, 2)) then
        call find_lines_after(first, samples, false_alarm, model, outcome, monitor)
      else                                         ! the lines of the contact do not gain enough any more
        call refit_in_new_noise(samples, model)
        call drop_lines(samples, false_alarm, model, dropped, monitor)
        best = state_of(samples, false_alarm, model)
        call improve_lines(samples, false_alarm, huge(1.0_dp), best, model, outcome, monitor)
      end if
      if (stops(monitor)) return
      if (.not. outcome%driven .and. size(model%lines) > 0) then
        call shorten_contact(missing, samples, false_alarm, length, model, cost, monitor)
        if (stops(monitor)) return
        outcome%contact = length
        if (size(first) < ubound(before%stretches, 2)) cost = cost - penalty_of_line(samples, false_alarm, model) &
          & *max(0, size(before%lines) - size(model%lines))   ! half a sine of force is a line, too, between its beginning and end
        if (cost < before%cost .or. with_contact%driven) return
      end if
      call leave_out_contact(missing, first, 0, samples, model)
      call go_back(samples, before, model)
      outcome = with_contact
    end subroutine try_contact

    logical function decays_without(first, length)
      !! Whether the longest stretch after a blow is a free decay without its first samples.
      integer, intent(in) :: first(:), length
      type(model_type) :: own
      type(line_outcome) :: decay
      integer :: last(size(first)), b
      last = [first(2:) - 1, samples%count]
      b = maxloc(last - first, dim=1)
      call find_lines_after([1], part_of(samples, first(b) + length, last(b)), false_alarm, own, decay, monitor)
      decays_without = .not. decay%driven .and. size(own%lines) > 0
    end function decays_without

    subroutine try_earlier_blow()
      !! Try whether the record begins within a decay. Its lines replace tones: these are no more, and J is lower.
      type(state_type) :: before, best
      type(line_outcome) :: within_tones
      logical :: is_better
      before = state_of(samples, false_alarm, model)
      within_tones = outcome
      if (outcome%driven) then
        call find_lines_after([1, blows], samples, false_alarm, model, outcome, monitor)
      else                                         ! from the lines found, which all decay
        call add_blow(model, 0, 1)
        model%lines%steady = .false.
        call refit_in_new_noise(samples, model)
        best = state_of(samples, false_alarm, model)
        call improve_lines(samples, false_alarm, huge(1.0_dp), best, model, outcome, monitor)
      end if
      if (stops(monitor)) return
      is_better = within_tones%driven .or. &
        & (size(model%lines) <= size(before%lines) .and. cost_of_all(samples, false_alarm, model) < before%cost)
      if (is_better .and. size(model%lines) > 0) return
      call go_back(samples, before, model)
      outcome = within_tones
    end subroutine try_earlier_blow

  end subroutine find_lines

end module bw_record_search
