module bw_repeat_cases
  !! Pooled lines of a result whose cases are repeats of one record.
  use bw_constants, only: two_pi
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_quantile, only: normal, student_quantile
  use bw_random_effects, only: pooled_number
  use bw_record_lines, only: status_words
  use bw_repeats, only: pool_repeats, pooled_lines, repeated_lines
  use bw_result_draft, only: result_draft
  use bw_result_layout, only: has
  implicit none (type, external)
  private
  public :: pooled_cases

  integer, parameter :: drifting = findloc(status_words == 'drifting', .true., dim=1) - 1      !! bit

contains

  function pooled_cases(draft) result(pooled)
    !! Pool the lines of all cases of a draft, in SI.
    type(result_draft), intent(inout) :: draft
    type(pooled_lines) :: pooled
    type(repeated_lines) :: lines
    real(dp), dimension(draft%layout%peaks) :: least
    real(dp) :: quantile                        ! half an interval in standard deviations
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
      least = epsilon(least)*max(lines%frequency(:, c), resolution)       ! for a record without noise
      call part_error(draft%get('measured_angular_frequency_error', c), draft%get('measured_angular_frequency_bound', c), &
                      quantile, drifts, least, lines%frequency_deviation(:, c), lines%frequency_drift(:, c))
      call part_error(draft%get('measured_decay_rate_error', c), draft%get('measured_decay_rate_bound', c), &
                      quantile, drifts, least, lines%decay_deviation(:, c), lines%decay_drift(:, c))
    end do
    pooled = pool_repeats(lines, resolution, draft%scene%spectrum%confidence, draft%scene%spectrum%false_alarm, &
                          draft%layout%peaks)
    if (draft%variable('measured_modal_constant_error') > 0) call pool_constants(draft, quantile, pooled)
    if (has(draft%layout, 'hammer frequency')) call pool_responses(draft, pooled)
  end function pooled_cases

  subroutine pool_constants(draft, quantile, pooled)
    !! Pool the modal constants of the lines that repeats share.
    type(result_draft), intent(inout) :: draft
    real(dp), intent(in) :: quantile          !! half an interval in standard deviations
    type(pooled_lines), intent(inout) :: pooled
    real(dp), dimension(draft%layout%peaks, draft%layout%points, draft%layout%cases) :: part, other, deviation
    integer :: c, k, s
    do c = 1, size(part, 3)
      part(:, :, c) = reshape(draft%get('measured_modal_constant_real', int(c, i8)), shape(part(:, :, c)))
      other(:, :, c) = reshape(draft%get('measured_modal_constant_imag', int(c, i8)), shape(part(:, :, c)))
      deviation(:, :, c) = reshape(draft%get('measured_modal_constant_error', int(c, i8)), shape(part(:, :, c)))
    end do
    where (.not. is_missing(deviation)) deviation = max(deviation/quantile, epsilon(deviation)*hypot(part, other))
    allocate (pooled%constant_real(size(pooled%count), draft%layout%points))
    pooled%constant_imag = pooled%constant_real
    associate (spectrum => draft%scene%spectrum)
      do s = 1, size(part, 2)
        do k = 1, size(pooled%count)
          associate (own => pooled%member == k)
            pooled%constant_real(k, s) = pooled_number(pack(part(:, s, :), own), pack(deviation(:, s, :), own), &
                                                       spectrum%confidence, spectrum%false_alarm)
            pooled%constant_imag(k, s) = pooled_number(pack(other(:, s, :), own), pack(deviation(:, s, :), own), &
                                                       spectrum%confidence, spectrum%false_alarm)
          end associate
        end do
      end do
    end associate
  end subroutine pool_constants

  subroutine pool_responses(draft, pooled)
    !! Find frequency responses from power and cross spectra averaged over all cases: with the force F and response HF
    !! of a case H1 = ΣH|F|²/Σ|F|², H2 = Σ|HF|²/Σ(H|F|²)*, coherence H1/H2. `missing` for a sensor without a response;
    !! coherence takes two.
    type(result_draft), intent(inout) :: draft
    type(pooled_lines), intent(inout) :: pooled
    real(dp), dimension(draft%layout%frequencies, draft%layout%points) :: part, force, response, power
    integer, dimension(draft%layout%frequencies, draft%layout%points) :: repeats   ! with a response
    complex(dp), dimension(draft%layout%frequencies, draft%layout%points) :: h, cross
    logical, dimension(draft%layout%frequencies, draft%layout%points) :: known
    integer(i8) :: c
    repeats = 0
    force = 0
    response = 0
    cross = 0
    do c = 1, draft%layout%cases
      part = reshape(draft%get('frequency_response_real', c), shape(part))
      power = spread(draft%get('force_spectrum', c), 2, size(power, 2))
      known = .not. is_missing(part)
      h = merge(cmplx(part, reshape(draft%get('frequency_response_imag', c), shape(part)), dp), (0.0_dp, 0.0_dp), known)
      power = merge(power**2, 0.0_dp, known)
      repeats = repeats + merge(1, 0, known)
      force = force + power
      cross = cross + h*power
      response = response + abs(h)**2*power
    end do
    allocate (pooled%h1_real, pooled%h1_imag, pooled%h2_real, pooled%h2_imag, pooled%coherence, &
              source=spread(spread(missing, 1, size(part, 1)), 2, size(part, 2)))
    where (force > 0 .and. abs(cross) > 0)
      pooled%h1_real = cross%re/force
      pooled%h1_imag = cross%im/force
      pooled%h2_real = response*cross%re/abs(cross)**2
      pooled%h2_imag = response*cross%im/abs(cross)**2
      pooled%coherence = merge(abs(cross)**2/(force*response), missing, repeats > 1)
    end where
  end subroutine pool_responses

  elemental subroutine part_error(error, bound, quantile, drifts, least, deviation, drift)
    !! Split half an interval into a standard deviation that varies between repeats, and the contribution of a drift
    !! along the record, which all repeats share.
    real(dp), intent(in) :: error, bound, quantile
    logical, intent(in) :: drifts
    real(dp), intent(in) :: least             !! least deviation
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
