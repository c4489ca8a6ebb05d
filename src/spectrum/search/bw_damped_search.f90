module bw_damped_search
  !! All lines of a record: they are searched for, the noise is whitened and separated by sensors, and they are searched for again.
  use bw_common_noise, only: find_mixture, mixture_type, separate
  use bw_damped_line, only: damped_line
  use bw_filter_renewal, only: deviation_left, filters_lines, take_filter_off, unfiltered_lines
  use bw_fourier, only: real_fourier
  use bw_found_lines, only: find_nothing, found_lines, noise_colour, rejected_line
  use bw_kinds, only: dp
  use bw_line_bands, only: prepare_bands
  use bw_line_or_colour, only: price_of
  use bw_line_refusals, only: drop_colour, drop_untold
  use bw_monitor, only: monitor_type, stops
  use bw_noise_level, only: mean_deviation
  use bw_ordinates, only: find_ordinates, least_ordinate, ordinates_type
  use bw_pure_record, only: find_lines_if_pure, safety
  use bw_samples, only: samples_type, span_of
  use bw_search_apart, only: search_apart, sum_amplitudes
  use bw_search_rounds, only: search, settle
  use bw_steady_noise, only: unsteady_share
  use bw_tapered_line, only: taper_costs
  use bw_whitening, only: find_whitening, is_even, is_steep, longest, whiten
  implicit none (type, external)
  private
  public :: find_damped_lines, fit_without

  integer, parameter :: most_filters = 3         !! one after the other, where lines are found behind a filter

contains

  subroutine find_damped_lines(samples, false_alarm, found, monitor)
    !! Find the lines of a record in which noise alone makes any line with the probability `false_alarm`. Where sensors share
    !! noise, lines are found once more at mixtures of sensors that do not. A search that is given up leaves no noise to tell it from.
    type(samples_type), intent(inout) :: samples
    real(dp), intent(in) :: false_alarm
    type(found_lines), intent(out) :: found    !! of no use where the monitor stops
    class(monitor_type), intent(inout), optional :: monitor
    type(real_fourier) :: plan
    type(mixture_type) :: rough
    logical :: pure
    call find_whitened_lines(samples, false_alarm, plan, found, rough, pure, monitor)
    if (pure .or. .not. found%at_rest) return
    if (stops(monitor)) return
    call find_mixture(samples, found%ordinates%seen, mean_deviation(found%ordinates%noise), found%mixture)
    if (allocated(found%mixture%mixed)) &
      & call find_separate_lines(samples, allocated(rough%mixed), false_alarm, plan, found, monitor)
  end subroutine find_damped_lines

  subroutine find_separate_lines(samples, known, false_alarm, plan, found, monitor)
    !! Turn the samples, as filters have left them, into those of mixtures of sensors whose noise is independent, and find their
    !! lines, from the beginning unless they are known.
    type(samples_type), intent(inout) :: samples
    logical, intent(in) :: known               !! the lines were found at mixtures, and shared noise has made none of them
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(found_lines) :: fresh
    call separate(found%mixture, samples)
    call find_nothing(size(samples%value, 2), fresh)
    if (known) then
      fresh%lines = found%lines
      call sum_amplitudes(found%mixture%separating, fresh%lines)
    end if
    fresh%mixture = found%mixture
    fresh%deviation = found%deviation
    fresh%unsteady = found%unsteady
    call settle(samples, fresh)
    call search(samples, false_alarm, plan, fresh, monitor)
    if (stops(monitor)) return
    if (fresh%at_rest .and. samples%count <= longest) &
      & call leave_out_colour(samples, samples, any(is_steep(found%whitening)), false_alarm, plan, fresh)
    fresh%whitening = found%whitening
    found = fresh
  end subroutine find_separate_lines

  subroutine find_whitened_lines(samples, false_alarm, plan, found, rough, pure, monitor)
    !! Find the lines of a record whose sensors' noise is taken for independent. Where the noise of even samples is coloured they
    !! are whitened in their memory, and searched once more; where it was lines that made the filter, all is done again from the lines
    !! that are known now. What a search leaves that is given up is no noise, and makes no filter; but all of the record may.
    !! Of samples that are known to be pure there are the lines and what they leave, and nothing else.
    type(samples_type), intent(inout) :: samples
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    type(mixture_type), intent(inout) :: rough     !! at which the lines were found, if sensors share noise in a large record
    logical, intent(out) :: pure
    class(monitor_type), intent(inout), optional :: monitor
    type(samples_type) :: raw
    type(rejected_line), allocatable :: refused(:)
    integer :: pass
    call find_nothing(size(samples%value, 2), found)
    call take_if_pure(samples, plan, found, pure, monitor)
    if (pure) return
    do pass = 1, most_filters
      if (stops(monitor)) return
      call search_apart(samples, false_alarm, plan, found, rough, monitor)
      found%deviation = found%ordinates%deviation
      if (stops(monitor)) return
      found%unsteady = unsteady_share(samples, found%lines, found%still)
      if (.not. found%at_rest) then
        if (pass == 1) call look_behind_filter(samples, false_alarm, plan, found, monitor)
        return
      end if
      if (samples%count <= longest) then
        raw = samples
        call leave_out_colour(raw, samples, .false., false_alarm, plan, found)
        found%deviation = found%ordinates%deviation
      end if
      if (allocated(samples%place)) return
      call find_whitening(samples, found%lines, found%still, found%whitening)
      if (all(found%whitening%order == 0)) return
      call whiten(samples, found%whitening, found%lines)
      refused = pack(found%rejected, found%rejected%reason == noise_colour)
      deallocate (found%bands, found%rejected)
      allocate (found%rejected(0))
      call search_apart(samples, false_alarm, plan, found, rough, monitor)
      call remember(refused, span_of(samples), found)
      if (.not. allocated(raw%value)) return
      call leave_out_colour(raw, samples, any(is_steep(found%whitening)), false_alarm, plan, found)
      if (pass == most_filters .or. .not. found%at_rest) return
      if (.not. filters_lines(raw, found)) return
      samples = raw
      call take_filter_off(found)
    end do
  end subroutine find_whitened_lines

  pure subroutine remember(refused, span, found)
    !! Add what was refused before the samples were whitened, where no line has been found since and nothing been refused again.
    type(rejected_line), intent(in) :: refused(:)
    real(dp), intent(in) :: span
    type(found_lines), intent(inout) :: found
    integer :: k
    do k = 1, size(refused)
      if (any(abs(found%lines%frequency - refused(k)%frequency)*span < 1)) cycle
      if (any(abs(found%rejected%frequency - refused(k)%frequency)*span < 1)) cycle
      found%rejected = [found%rejected, refused(k)]
    end do
  end subroutine remember

  subroutine look_behind_filter(samples, false_alarm, plan, found, monitor)
    !! Where a search was given up, what it has taken for lines may be noise whose band ends steeply. Whiten the samples with all that
    !! is in them, and search them once more: of the two, that stays which costs less. What dies away is no noise.
    type(samples_type), intent(inout) :: samples
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(found_lines) :: fresh
    type(samples_type) :: raw
    real(dp) :: threshold, still(2, size(samples%value, 2))
    integer :: s
    if (allocated(samples%place) .or. samples%count > longest) return
    if (.not. all([(is_even(samples%value(:samples%count, s)), s=1, size(samples%value, 2))])) return
    call find_nothing(size(samples%value, 2), fresh)
    call settle(samples, fresh)
    call find_whitening(samples, fresh%lines, fresh%still, fresh%whitening)
    if (all(fresh%whitening%order == 0)) return
    raw = samples
    call whiten(samples, fresh%whitening, fresh%lines)
    deallocate (fresh%bands)
    call settle(samples, fresh)
    call search(samples, false_alarm, plan, fresh, monitor)
    if (stops(monitor)) return
    if (fresh%at_rest) then
      call leave_out_colour(raw, samples, any(is_steep(fresh%whitening)), false_alarm, plan, fresh)
      threshold = least_ordinate(fresh%ordinates%shape, span_of(raw)/2, false_alarm)
      if (price_of(raw, unfiltered_lines(fresh), threshold) < price_of(raw, found%lines, threshold)) then
        still = 0
        still(1, :) = sum(raw%value(:raw%count, :), dim=1)/raw%count
        fresh%deviation = deviation_left(raw, unfiltered_lines(fresh))
        fresh%unsteady = unsteady_share(raw, unfiltered_lines(fresh), still)
        found = fresh
        return
      end if
    end if
    samples = raw
  end subroutine look_behind_filter

  subroutine leave_out_colour(raw, samples, steep, false_alarm, plan, found)
    !! Leave out lines that the colour of the noise explains, and fit the others again.
    type(samples_type), intent(in) :: raw      !! as they were before they were whitened
    type(samples_type), intent(in) :: samples
    logical, intent(in) :: steep               !! the noise is that of a steep filter
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    type(ordinates_type) :: tapered
    logical :: dropped
    call drop_colour(raw, samples, steep, false_alarm, found, dropped)
    if (.not. dropped) return
    call settle(samples, found)
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
  end subroutine leave_out_colour

  subroutine fit_without(samples, untold, found, monitor)
    !! Leave out lines of which the record tells nothing, and fit the others again.
    type(samples_type), intent(in) :: samples  !! as `find_damped_lines` has left them
    logical, intent(in) :: untold(:)           !! (lines)
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(real_fourier) :: plan
    type(ordinates_type) :: tapered
    call drop_untold(samples, untold, found)
    call settle(samples, found, monitor)
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
  end subroutine fit_without

  subroutine take_if_pure(samples, plan, found, pure, monitor)
    !! Take the lines of a record that holds nothing else but rounding, which is its noise.
    type(samples_type), intent(in) :: samples
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: pure
    class(monitor_type), intent(inout), optional :: monitor
    type(damped_line), allocatable :: lines(:)
    type(ordinates_type) :: tapered
    logical, allocatable :: is_offset(:)
    integer :: k
    call find_lines_if_pure(samples, lines, found%left, pure, monitor)
    if (samples%pure) call move_alloc(lines, found%lines)
    if (samples%pure .or. .not. pure) return
    is_offset = lines%steady .and. .not. lines%frequency > 0
    do k = 1, size(lines)
      if (is_offset(k)) found%still(1, :) = found%still(1, :) + lines(k)%amplitude%re
    end do
    found%lines = pack(lines, .not. is_offset)
    found%lines%steady = .false.
    call prepare_bands(samples, found%lines, found%bands)
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
    found%ordinates%noise%level = (safety*taper_costs)**2*found%ordinates%noise%level
    found%deviation = found%ordinates%deviation
  end subroutine take_if_pure

end module bw_damped_search
