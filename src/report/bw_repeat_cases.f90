module bw_repeat_cases
  !! The lines of all cases of a result whose cases are repeats of one record, pooled.
  use bw_constants, only: two_pi
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_quantile, only: normal, student_quantile
  use bw_record_lines, only: status_words
  use bw_repeats, only: pool_repeats, pooled_lines, repeated_lines
  use bw_result_draft, only: result_draft
  implicit none (type, external)
  private
  public :: pooled_cases

  integer, parameter :: drifting = findloc(status_words == 'drifting', .true., dim=1) - 1      !! bit

contains

  function pooled_cases(draft) result(pooled)
    !! What all cases of a draft say together, in SI.
    type(result_draft), intent(inout) :: draft
    type(pooled_lines) :: pooled
    type(repeated_lines) :: lines
    real(dp), dimension(draft%layout%peaks) :: least
    real(dp) :: quantile                        ! standard deviations of half an interval
    real(dp) :: resolution                      ! rad/s, of the longest record
    logical :: drifts(draft%layout%peaks)
    integer(i8) :: c
    quantile = student_quantile(draft%scene%spectrum%confidence, normal)
    resolution = two_pi/draft%layout%record%duration
    allocate (lines%frequency(draft%layout%peaks, draft%layout%cases), source=missing)
    lines%frequency_deviation = lines%frequency
    lines%decay = lines%frequency
    lines%decay_deviation = lines%frequency
    allocate (lines%frequency_drift(draft%layout%peaks, draft%layout%cases), source=0.0_dp)
    lines%decay_drift = lines%frequency_drift
    do c = 1, draft%layout%cases
      lines%frequency(:, c) = draft%get('measured_angular_frequency', c)
      lines%decay(:, c) = draft%get('measured_decay_rate', c)
      drifts = btest(nint(draft%get('peak_status', c)), drifting)
      least = epsilon(least)*max(lines%frequency(:, c), resolution)       ! of a record without noise
      call part_error(draft%get('measured_angular_frequency_error', c), draft%get('measured_angular_frequency_bound', c), &
                      quantile, drifts, least, lines%frequency_deviation(:, c), lines%frequency_drift(:, c))
      call part_error(draft%get('measured_decay_rate_error', c), draft%get('measured_decay_rate_bound', c), &
                      quantile, drifts, least, lines%decay_deviation(:, c), lines%decay_drift(:, c))
    end do
    pooled = pool_repeats(lines, resolution, draft%scene%spectrum%confidence, draft%scene%spectrum%false_alarm, &
                          draft%layout%peaks)
  end function pooled_cases

  elemental subroutine part_error(error, bound, quantile, drifts, least, deviation, drift)
    !! Part half an interval into what differs from repeat to repeat, as a standard deviation, and what a drift along the record
    !! adds to it, which is the same in each.
    real(dp), intent(in) :: error, bound, quantile
    logical, intent(in) :: drifts
    real(dp), intent(in) :: least             !! deviation
    real(dp), intent(out) :: deviation, drift
    deviation = missing
    drift = 0
    if (is_missing(error)) return
    deviation = max(error/quantile, least)
    if (.not. drifts .or. is_missing(bound)) return
    deviation = max(min(bound, deviation), least)
    drift = max(0.0_dp, error - quantile*deviation)
  end subroutine part_error

end module bw_repeat_cases
