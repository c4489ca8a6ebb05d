module bw_blow_contact
  !! Blows that last: while the hammer touches the beam its motion is no free decay. The first samples after each blow are left out
  !! if that lowers J, where the samples left out are unknowns.
  use bw_cost, only: cost_of_all
  use bw_kinds, only: dp
  use bw_line, only: life_of
  use bw_model, only: model_type
  use bw_monitor, only: monitor_type, stops
  use bw_penalty, only: chi_squared
  use bw_samples, only: gaps_of, gaps_type, samples_type, set_missing
  use bw_search_state, only: go_back, refit_in_new_noise, state_of, state_type
  use bw_stretches, only: shift_blow
  implicit none (type, external)
  private
  public :: beginnings, leave_out_contact, may_last, most_left_out, shorten_contact

  integer, parameter :: longest = 64             !! samples of a contact
  integer, parameter :: fewest = 16              !! times as many in the shortest stretch
  integer, parameter :: looked_at = 8            !! samples after a blow whose residual tells whether there is a contact
  real(dp), parameter :: shrinkage = 1.25_dp     !! from one length tried to the next

contains

  pure logical function may_last(false_alarm, model)
    !! Whether lines or their residual stand out soon after a blow, as they do if it lasts.
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model        !! renewed
    real(dp) :: squares
    integer :: b, k, rows, freedom
    may_last = size(beginnings(model%stretches(1, 1:))) < ubound(model%stretches, 2)
    do k = 1, size(model%lines)
      may_last = may_last .or. life_of(model%lines(k), 1.0_dp, real(size(model%white, 1), dp)) < longest
    end do
    squares = 0
    freedom = 2
    do b = 1, ubound(model%stretches, 2)
      associate (first => model%stretches(1, b))
        rows = min(looked_at, model%stretches(2, b) - first + 1)
        squares = squares + sum(model%white(first:first + rows - 1, :)**2)
        freedom = freedom + rows*size(model%white, 2)
      end associate
    end do
    may_last = may_last .or. squares > chi_squared(false_alarm, 2*(freedom/2))
  end function may_last

  pure function beginnings(blows) result(first)
    !! The blows without those that follow within the length of a contact, which may be its end.
    integer, intent(in) :: blows(:)
    integer, allocatable :: first(:)
    integer :: b
    first = blows(:1)
    do b = 2, size(blows)
      if (blows(b) - first(size(first)) >= longest) first = [first, blows(b)]
    end do
  end function beginnings

  pure integer function most_left_out(blows, count) result(length)
    !! The most samples that may be left out after each blow.
    integer, intent(in) :: blows(:)
    integer, intent(in) :: count                 !! N
    length = min(longest, minval([blows(2:), count + 1] - blows)/fewest)
  end function most_left_out

  subroutine shorten_contact(missing, samples, false_alarm, length, model, cost, monitor)
    !! Leave out as many samples after each blow, or none, as make J least.
    type(gaps_type), intent(in) :: missing(:)    !! missing samples without the contact
    type(samples_type), intent(inout) :: samples !! without `length` samples after each blow
    real(dp), intent(in) :: false_alarm
    integer, intent(inout) :: length
    type(model_type), intent(inout) :: model
    real(dp), intent(out) :: cost                !! J of all samples
    class(monitor_type), intent(inout), optional :: monitor
    type(state_type) :: best
    real(dp) :: now
    integer :: side, tried, shorter, b
    best = state_of(samples, false_alarm, model)
    cost = cost_beside_contact(samples, false_alarm, model, length)
    do side = 1, 2                               ! from its end, then from its beginning
      tried = length
      do while (tried > side - 1)
        if (stops(monitor)) return
        shorter = min(tried - 1, nint(tried/shrinkage))
        do b = 1, merge(ubound(model%stretches, 2), 0, side == 2)
          call shift_blow(model, b, model%stretches(1, b) + tried - shorter)
        end do
        tried = shorter
        call leave_out_contact(missing, model%stretches(1, 1:), tried, samples, model)
        call refit_in_new_noise(samples, model)
        now = cost_beside_contact(samples, false_alarm, model, tried)
        if (now >= cost) cycle
        cost = now
        length = tried
        best = state_of(samples, false_alarm, model)
      end do
      call leave_out_contact(missing, best%stretches(1, 1:), length, samples, model)
      call go_back(samples, best, model)
    end do
  end subroutine shorten_contact

  pure subroutine leave_out_contact(missing, blows, length, samples, model)
    !! Mark samples as missing, and the first after each blow at all sensors.
    type(gaps_type), intent(in) :: missing(:)    !! (S)
    integer, intent(in) :: blows(:)
    integer, intent(in) :: length
    type(samples_type), intent(inout) :: samples
    type(model_type), intent(inout) :: model     !! has to be renewed
    type(gaps_type) :: marked(size(missing))
    logical :: valid(samples%count)
    integer :: s, b
    do s = 1, size(missing)
      valid = .true.
      valid(missing(s)%place) = .false.
      do b = 1, size(blows)
        valid(blows(b):min(samples%count, blows(b) + length - 1)) = .false.
      end do
      marked(s) = gaps_of(valid)
    end do
    call set_missing(marked, samples)
    call forget_missing(model)
  end subroutine leave_out_contact

  pure subroutine forget_missing(model)
    !! Forget what belongs to other missing samples.
    type(model_type), intent(inout) :: model
    if (allocated(model%start)) deallocate (model%start)
    if (allocated(model%last)) deallocate (model%last)
    if (allocated(model%missing)) deallocate (model%missing)
  end subroutine forget_missing

  pure real(dp) function cost_beside_contact(samples, false_alarm, model, length) result(cost)
    !! J with so many samples after each blow left out, as it compares with J of all samples: as if these were free to fit exactly.
    !! Their penalty is what noise alone gains without them, for some length.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    integer, intent(in) :: length
    integer :: lost
    lost = length*ubound(model%stretches, 2)
    cost = cost_of_all(samples, false_alarm, model) + lost*model%noise%cost/(samples%count - lost) &
      & + chi_squared(false_alarm/longest, 2*((lost*size(samples%value, 2) + 1)/2))
  end function cost_beside_contact

end module bw_blow_contact
