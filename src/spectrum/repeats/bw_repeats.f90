module bw_repeats
  !! Repeats of one measurement: the lines that they share, and the scatter of frequencies and decay rates.
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_order, only: ascending
  use bw_random_effects, only: middle_of, pooled_number, pooled_value
  implicit none (type, external)
  private
  public :: matched_lines, pool_repeats

  character(*), parameter, public :: pooled_words(*) = [character(18) :: 'repeats', 'frequency_scatters', 'decay_scatters', &
    'drifting']
    !! bits 1, 2, 4, 8: a number scatters if the cases differ by more than their standard deviations explain; `repeats` means
    !! none of the others
  real(dp), parameter :: wander = 0.002_dp  !! relative; frequencies of repeats may well differ by as much if beams are reassembled
  real(dp), parameter :: gate = 9           !! squared standard deviations, plus the log of the variance, at which lines differ

  type, public :: repeated_lines
    !! The lines of some cases by ascending frequency, followed by `missing` frequencies. A deviation is the standard deviation
    !! of a case by itself, `missing` if unknown. Drift is the part of the half-width of an interval that is due to a change along
    !! the record, which is the same in each repeat and does not average out.
    real(dp), allocatable, dimension(:, :) :: frequency, frequency_deviation, frequency_drift   !! (lines, cases)
    real(dp), allocatable, dimension(:, :) :: decay, decay_deviation, decay_drift               !! (lines, cases)
  end type repeated_lines

  type, public :: pooled_lines
    !! Lines that at least two cases have, by ascending frequency.
    type(pooled_value), allocatable :: frequency(:), decay(:)    !! (pooled)
    integer, allocatable :: count(:)                             !! of the cases that have the line, (pooled)
    integer, allocatable :: status(:)                            !! sum of bits of `pooled_words`, (pooled)
    integer, allocatable :: member(:, :)                         !! pooled line of each line of each case; 0: none, (lines, cases)
    real(dp), allocatable, dimension(:, :) :: h1_real, h1_imag, h2_real, h2_imag, coherence
      !! from blows of a hammer: H1, H2 in the sensors' units over 1 N, and coherence, (frequencies, sensors); unallocated: none
    type(pooled_value), allocatable, dimension(:, :) :: constant_real, constant_imag
      !! modal constants from blows of a hammer, 1/kg, (pooled, sensors); unallocated: none
  end type pooled_lines

  type :: repeat_group
    !! Lines that are taken as the same, weighted by 1/variance.
    integer :: lines = 0
    real(dp) :: weight = 0, moment = 0
  contains
    procedure :: update
  end type repeat_group

contains

  pure type(pooled_lines) function pool_repeats(lines, resolution, confidence, false_alarm, most) result(pooled)
    !! Pool the lines that at least two cases have; if these are more than `most`, those that most cases have.
    type(repeated_lines), intent(in) :: lines
    real(dp), intent(in) :: resolution         !! 1/duration, in the unit of frequencies
    real(dp), intent(in) :: confidence         !! of the intervals, 0 … 1
    real(dp), intent(in) :: false_alarm
    integer, intent(in) :: most
    integer :: k
    allocate (pooled%member, source=matched_lines(lines%frequency, lines%frequency_deviation, resolution))
    call keep_repeated(lines%frequency, most, pooled%member)
    allocate (pooled%count, source=[(count(pooled%member == k), k=1, maxval(pooled%member))])
    allocate (pooled%frequency(size(pooled%count)), pooled%decay(size(pooled%count)), pooled%status(size(pooled%count)))
    do k = 1, size(pooled%count)
      associate (own => pooled%member == k)
        pooled%frequency(k) = with_drift(pooled_number(pack(lines%frequency, own), pack(lines%frequency_deviation, own), &
                                                       confidence, false_alarm), pack(lines%frequency_drift, own))
        pooled%decay(k) = with_drift(pooled_number(pack(lines%decay, own), pack(lines%decay_deviation, own), &
                                                   confidence, false_alarm), pack(lines%decay_drift, own))
      end associate
      pooled%status(k) = status_of(pooled%frequency(k), pooled%decay(k))
    end do
  end function pool_repeats

  pure type(pooled_value) function with_drift(pooled, drift) result(wider)
    !! The pooled value with its interval widened by the median drift of the repeats.
    type(pooled_value), intent(in) :: pooled
    real(dp), intent(in) :: drift(:)
    wider = pooled
    if (is_missing(pooled%error)) return
    wider%drift = middle_of(drift)
    wider%error = pooled%error + wider%drift
  end function with_drift

  pure integer function status_of(frequency, decay) result(status)
    !! The status: a sum of bits of `pooled_words`.
    type(pooled_value), intent(in) :: frequency, decay
    status = 0
    if (frequency%scatters) status = ibset(status, 1)
    if (decay%scatters) status = ibset(status, 2)
    if (frequency%drift > 0 .or. decay%drift > 0) status = ibset(status, 3)
    if (status == 0) status = 1
  end function status_of

  pure function matched_lines(frequency, deviation, resolution) result(member)
    !! Number the lines of all cases so that equal numbers mean the same line; 0 where there is no line, or its error is unknown.
    !! Each case in turn is assigned to the groups found so far, in two passes, so that the second uses the groups of all cases.
    real(dp), intent(in) :: frequency(:, :), deviation(:, :)    !! (lines, cases); `missing` after the last line
    real(dp), intent(in) :: resolution
    integer :: member(size(frequency, 1), size(frequency, 2))
    type(repeat_group), allocatable :: groups(:)
    integer, allocatable :: known(:)
    integer :: pass, case, i
    allocate (groups(0))
    member = 0
    do pass = 1, 2
      do case = 1, size(frequency, 2)
        known = pack([(i, i=1, size(member, 1))], .not. (is_missing(frequency(:, case)) .or. is_missing(deviation(:, case))))
        associate (x => frequency(known, case), width => width_at(frequency(known, case), resolution)**2)
          associate (variance => deviation(known, case)**2 + width)
            do i = 1, size(known)
              if (member(known(i), case) > 0) call groups(member(known(i), case))%update(x(i), variance(i), -1)
            end do
            member(known, case) = assigned(x, variance, width, groups)
            do i = 1, size(known)
              if (member(known(i), case) == 0) then
                groups = [groups, repeat_group()]
                member(known(i), case) = size(groups)
              end if
              call groups(member(known(i), case))%update(x(i), variance(i), 1)
            end do
          end associate
        end associate
      end do
    end do
  end function matched_lines

  elemental real(dp) function width_at(frequency, resolution) result(width)
    !! The standard deviation by which lines of repeats may differ, besides their errors, and still be the same: half the
    !! resolution of one record, combined with the usual variation of beams.
    real(dp), intent(in) :: frequency, resolution
    width = hypot(resolution/2, wander*frequency)
  end function width_at

  elemental subroutine update(self, x, variance, times)
    !! Add a line to a group, or remove it.
    class(repeat_group), intent(inout) :: self
    real(dp), intent(in) :: x, variance
    integer, intent(in) :: times               !! 1, or −1
    self%lines = self%lines + times
    self%weight = self%weight + times/variance
    self%moment = self%moment + times*x/variance
  end subroutine update

  pure function assigned(x, variance, width, groups) result(partner)
    !! The group of each line of a case, 0 if it has none. Each group is used once and in ascending order; the assignment has the
    !! largest likelihood. The gain of a pair is the gate minus −2 ln of its likelihood.
    real(dp), intent(in) :: x(:), variance(:), width(:)    !! ascending; `width` is the variance besides errors
    type(repeat_group), intent(in) :: groups(:)
    integer :: partner(size(x))
    integer, allocatable :: order(:)
    real(dp), allocatable :: best(:, :)        ! largest gain of the first lines with the first groups
    real(dp) :: total
    integer :: i, j
    order = pack([(j, j=1, size(groups))], groups%lines > 0)
    order = order(ascending(groups(order)%moment/groups(order)%weight))
    allocate (best(0:size(x), 0:size(order)), source=0.0_dp)
    do i = 1, size(x)
      do j = 1, size(order)
        associate (group => groups(order(j)))
          total = variance(i) + 1/group%weight
          best(i, j) = max(best(i - 1, j), best(i, j - 1), best(i - 1, j - 1) + gate &
                           - (x(i) - group%moment/group%weight)**2/total - log(total/(2*width(i))))
        end associate
      end do
    end do
    partner = 0
    i = size(x)
    j = size(order)
    do while (i > 0 .and. j > 0)
      if (best(i, j) <= best(i - 1, j)) then
        i = i - 1
      else if (best(i, j) <= best(i, j - 1)) then
        j = j - 1
      else
        partner(i) = order(j)
        i = i - 1
        j = j - 1
      end if
    end do
  end function assigned

  pure subroutine keep_repeated(frequency, most, member)
    !! Keep the lines that at least two cases have, at most `most` of them, and number these by ascending frequency.
    real(dp), intent(in) :: frequency(:, :)    !! (lines, cases)
    integer, intent(in) :: most
    integer, intent(inout) :: member(:, :)     !! (lines, cases)
    integer, allocatable :: cases(:), order(:), number(:)
    real(dp), allocatable :: sums(:)
    integer :: line, case, k
    allocate (cases(0:maxval(member)), sums(0:maxval(member)), number(0:maxval(member)))
    cases = 0
    sums = 0
    do case = 1, size(member, 2)
      do line = 1, size(member, 1)
        k = member(line, case)
        cases(k) = cases(k) + 1
        if (k > 0) sums(k) = sums(k) + frequency(line, case)
      end do
    end do
    order = ascending(-real(cases(1:), dp))
    order = order(:min(most, count(cases(1:) > 1)))
    order = order(ascending(sums(order)/cases(order)))
    number = 0
    number(order) = [(k, k=1, size(order))]
    do case = 1, size(member, 2)
      member(:, case) = number(member(:, case))
    end do
  end subroutine keep_repeated

end module bw_repeats
