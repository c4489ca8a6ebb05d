module bw_line_refusals
  !! Lines that are none: not needed, too broad, taken astray by a fit, uncertain, or explained by the colour of the noise.
  use bw_band_fit, only: reduce, reduced_type, widest_drift
  use bw_damped_line, only: bend_reach, cancels, damped_line, overlap, same_peak, strength_of
  use bw_filter_renewal, only: unfiltered_lines
  use bw_found_lines, only: beside_drift, drift_reach, far_above, found_lines, noise_colour, not_needed, rejected_line, &
    & too_broad, uncertain
  use bw_kinds, only: dp
  use bw_level_beside, only: stands_out_beside
  use bw_line_bands, only: own_rows, weight_of
  use bw_line_errors, only: amplitude_deviation, frequency_deviation, line_errors, line_errors_of
  use bw_line_or_colour, only: are_lines
  use bw_noise_level, only: window_width
  use bw_ordinates, only: least_ordinate, ordinates_type
  use bw_samples, only: centre_of, samples_type, span_of
  implicit none (type, external)
  private
  public :: drop_astray, drop_beside_drift, drop_broad, drop_cancelling, drop_colour, drop_needless, drop_uncertain, &
    & drop_untold, place_of, refuse_untold

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: kept = 1                !! times the threshold, that a line must still pay among the others
  real(dp), parameter :: shortest_life = 0.25_dp !! decay per step: gone after four samples
  real(dp), parameter :: sigmas = 2              !! standard deviations of an interval, that tells whether there is a line at all
  real(dp), parameter :: widest_error = 3        !! bins, of a frequency
  integer, parameter :: straight = 2             !! powers of time in the exponent of a line whose frequency drifts evenly
  integer, parameter :: crowd = 2                !! weaker lines in the peak of a line, and more
  real(dp), parameter :: clear_of_still = 8      !! bins from 0, where an offset that changes leaks no more
  real(dp), parameter :: strayed = 2             !! bins, and half widths, that a fit may take a line from its peak

contains

  subroutine drop_broad(samples, threshold, found, changed)
    !! Leave out lines too broad to be told from the noise's colour, unless they pay far more than that; they are not tried again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: threshold
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    logical, dimension(size(found%lines)) :: broad, gone
    real(dp) :: pays(size(found%lines))
    changed = .false.
    broad = abs(found%lines%decay) > pi*window_width(span_of(samples)/2)/(2*span_of(samples))
    gone = abs(found%lines%decay) > shortest_life
    if (.not. any(broad .or. gone)) return
    pays = pays_of(samples, found, broad .or. gone)
    gone = gone .or. (broad .and. pays < far_above*threshold)
    call reject(merge(too_broad, 0, gone), pays, found, changed)
  end subroutine drop_broad

  subroutine drop_needless(samples, threshold, found, changed)
    !! Leave out lines without which the others explain as much but for noise; they are not tried again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: threshold
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    real(dp) :: pays(size(found%lines))
    logical :: all_lines(size(found%lines))
    all_lines = .true.
    pays = pays_of(samples, found, all_lines)
    call reject(merge(not_needed, 0, pays <= kept*threshold), pays, found, changed)
  end subroutine drop_needless

  subroutine drop_astray(samples, known, found, changed)
    !! Leave out lines that a fit has taken to where no peak was: they describe what others leave beside them, or the noise's colour.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: known                 !! lines that were there before, and come first
    type(found_lines), intent(inout) :: found    !! its ordinates are those before the others were taken up
    logical, intent(out) :: changed
    real(dp) :: ordinate(size(found%lines))
    integer :: reason(size(found%lines)), k
    reason = 0
    ordinate = 0
    do k = known + 1, size(found%lines)
      associate (line => found%lines(k), others => found%lines(:known))
        if (abs(line%frequency - line%sought)*span_of(samples) < strayed + abs(line%decay)*span_of(samples)/pi) cycle
        reason(k) = not_needed
        ordinate(k) = ordinate_at(found%ordinates, merge(line%sought, line%frequency, line%sought >= 0))
        if (any(others%powers > 1 .and. abs(others%frequency - line%frequency)*span_of(samples) < drift_reach)) &
          & reason(k) = beside_drift
        if (reason(k) == not_needed .and. line%sought >= 0) line%frequency = line%sought  ! another may be where it has gone
      end associate
    end do
    call reject(reason, ordinate, found, changed)
  end subroutine drop_astray

  subroutine drop_cancelling(samples, found, changed)
    !! Leave out the last of the lines that are in the record by their difference alone.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    integer :: reason(size(found%lines)), k
    reason = 0
    do k = size(found%lines), 1, -1
      if (.not. cancels(found%lines(k), found%highest)) cycle
      reason(k) = not_needed
      exit
    end do
    changed = any(reason > 0)
    if (changed) call reject(reason, pays_of(samples, found, reason > 0), found, changed)
  end subroutine drop_cancelling

  subroutine drop_beside_drift(samples, found, changed)
    !! Leave out weaker lines in the band that a line sweeps whose drift is more than a straight line: no record tells them from what
    !! the powers of time do not describe of that drift. So are two or more in the peak of one line, each as far as it is broad:
    !! together they describe any drift. They are not tried again.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    complex(dp) :: reach
    real(dp), dimension(size(found%lines)) :: strength, energy, width, bins
    logical :: near(size(found%lines))
    integer :: reason(size(found%lines)), j
    reason = 0
    associate (lines => found%lines, span => span_of(samples))
      strength = strength_of(lines)
      width = abs(lines%decay)*span/(2*pi)
      energy = strength**2/max(width, 1.0_dp)
      do j = 1, size(lines)
        bins = abs(lines%frequency - lines(j)%frequency)*span
        if (lines(j)%powers > straight) then
          reach = bend_reach(lines(j), centre_of(samples))
          where (strength < strength(j) .and. bins < drift_reach + min(reach%im, widest_drift)/pi) reason = beside_drift
        end if
        if (lines(j)%frequency*span < clear_of_still) cycle
        near = energy < energy(j) .and. bins < drift_reach + width
        if (count(near) >= crowd) where (near) reason = beside_drift
      end do
    end associate
    changed = any(reason > 0)
    if (changed) call reject(reason, pays_of(samples, found, reason > 0), found, changed)
  end subroutine drop_beside_drift

  pure real(dp) function ordinate_at(ordinates, frequency)
    !! The ordinate nearest to a frequency in periods per step.
    type(ordinates_type), intent(in) :: ordinates
    real(dp), intent(in) :: frequency
    ordinate_at = ordinates%total(max(0, min(ubound(ordinates%total, 1), nint(frequency*ordinates%length))))
  end function ordinate_at

  subroutine drop_uncertain(samples, found, changed)
    !! Leave out lines that share no peak and that the record does not determine: at no sensor is the amplitude, where it is
    !! largest, above its own interval, or the frequency's interval is as wide as the frequency, or wider than the line, or a
    !! drift takes it to 0 or to half the sampling rate. They are not tried again.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    type(line_errors) :: errors
    real(dp) :: span, error, pays(size(found%lines))
    integer :: reason(size(found%lines)), i, j
    reason = 0
    span = span_of(samples)
    do i = 1, size(found%bands)
      if (size(found%bands(i)%member) == 0) cycle
      associate (band => found%bands(i), own => found%lines(found%bands(i)%member))
        errors = line_errors_of(reduce(samples, band%band, own_rows(samples, found%lines, found%still, band), own, &
          & band%with_still), weight_of(found%ordinates%noise, band, size(samples%value, 2)))
        do j = 1, size(own)
          if (own(j)%frequency*span > same_peak .and. &
            & count(overlap(own, own(j), span)) > 1) cycle
          if (.not. stands_out(errors, own(j), j)) reason(band%member(j)) = uncertain
          if (leaves(samples, own(j))) reason(band%member(j)) = uncertain
          if (own(j)%frequency*span < 1) cycle
          error = sigmas*frequency_deviation(errors, j)/pi
          if (error > min(own(j)%frequency*span, widest_error + abs(own(j)%decay)*span/pi)) reason(band%member(j)) = uncertain
        end do
      end associate
    end do
    pays = 0
    if (any(reason > 0)) pays = pays_of(samples, found, reason > 0)
    call reject(reason, pays, found, changed)
  end subroutine drop_uncertain

  subroutine drop_untold(samples, untold, found)
    !! Leave out lines of which the record tells nothing.
    type(samples_type), intent(in) :: samples
    logical, intent(in) :: untold(:)
    type(found_lines), intent(inout) :: found
    logical :: changed
    call reject(merge(uncertain, 0, untold), pays_of(samples, found, untold), found, changed)
  end subroutine drop_untold

  subroutine refuse_untold(samples, untold, found)
    !! The same of lines that stay in the fit.
    type(samples_type), intent(in) :: samples
    logical, intent(in) :: untold(:)
    type(found_lines), intent(inout) :: found
    type(damped_line) :: lines(size(found%lines))
    lines = found%lines
    call drop_untold(samples, untold, found)
    found%lines = lines
  end subroutine refuse_untold

  logical function leaves(samples, line)
    !! Whether a drift takes a line to 0 or to half the sampling rate.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: line
    complex(dp) :: reach
    reach = bend_reach(line, centre_of(samples))/(2*pi*centre_of(samples))
    leaves = line%powers > 1 .and. line%frequency <= reach%im
    if (.not. allocated(samples%place)) leaves = leaves .or. (line%powers > 1 .and. line%frequency + reach%im >= 0.5_dp)
  end function leaves

  logical function stands_out(errors, line, j)
    !! Whether an amplitude, where it is largest over the record, is above its own interval at any sensor.
    type(line_errors), intent(in) :: errors
    type(damped_line), intent(in) :: line
    integer, intent(in) :: j                     !! its place in the fit
    real(dp) :: along(2, size(line%amplitude))
    integer :: s
    stands_out = .true.
    do s = 1, size(line%amplitude)
      associate (a => line%amplitude(s))
        along = 0
        along(:, s) = [a%re, a%im]/max(abs(a), tiny(1.0_dp))
        if (abs(a) > sigmas*amplitude_deviation(errors, j, along, last=line%decay < 0)) return
      end associate
    end do
    stands_out = .false.
  end function stands_out

  subroutine drop_colour(raw, samples, steep, false_alarm, found, dropped)
    !! Leave out lines that the colour of the noise explains, and behind a steep filter those that do not stand out of the ordinates
    !! beside them.
    type(samples_type), intent(in) :: raw      !! as they were before they were whitened
    type(samples_type), intent(in) :: samples
    logical, intent(in) :: steep
    real(dp), intent(in) :: false_alarm
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: dropped
    type(damped_line) :: lines(size(found%lines))
    logical :: stays(size(found%lines))
    real(dp) :: pays(size(found%lines)), threshold
    integer :: k
    threshold = least_ordinate(found%ordinates%shape, span_of(raw)/2, false_alarm)
    stays = .true.
    pays = pays_of(samples, found, stays)
    lines = unfiltered_lines(found)
    stays = are_lines(raw, steep, lines, pays, threshold)
    if (steep) stays = stays .and. &
      & [(stands_out_beside(samples, found%ordinates, lines(k), pays(k), threshold), k=1, size(lines))]
    dropped = .not. all(stays)
    do k = 1, size(lines)
      if (stays(k)) cycle
      found%rejected = [found%rejected, rejected_line(lines(k)%frequency, pays(k), noise_colour, place_of(lines(k), found))]
    end do
    found%lines = pack(found%lines, stays)
  end subroutine drop_colour

  function pays_of(samples, found, asked) result(pays)
    !! What each line that is asked for takes off half the squares over the noise's level, beside the others of its band.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    logical, intent(in) :: asked(:)
    real(dp) :: pays(size(found%lines))
    type(reduced_type) :: with, without
    real(dp), allocatable :: rows(:, :), weight(:)
    integer, allocatable :: others(:)
    integer :: i, j
    pays = 0
    do i = 1, size(found%bands)
      if (.not. any(asked(found%bands(i)%member))) cycle
      associate (band => found%bands(i))
        rows = own_rows(samples, found%lines, found%still, band)
        weight = weight_of(found%ordinates%noise, band, size(samples%value, 2))
        with = reduce(samples, band%band, rows, found%lines(band%member), band%with_still, 0*band%member)
        do j = 1, size(band%member)
          if (.not. asked(band%member(j))) cycle
          others = pack(band%member, band%member /= band%member(j))
          without = reduce(samples, band%band, rows, found%lines(others), band%with_still, 0*others)
          pays(band%member(j)) = sum(weight*(without%left - with%left))/2
        end do
      end associate
    end do
  end function pays_of

  subroutine reject(reason, ordinate, found, changed)
    !! Move lines to the rejected ones.
    integer, intent(in) :: reason(:)             !! 0 for lines that stay
    real(dp), intent(in) :: ordinate(:)          !! of those that do not
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    integer :: k
    do k = 1, size(reason)
      if (reason(k) == 0) cycle
      found%rejected = [found%rejected, &
        & rejected_line(found%lines(k)%frequency, ordinate(k), reason(k), place_of(found%lines(k), found))]
    end do
    changed = any(reason > 0)
    if (changed) found%lines = pack(found%lines, reason == 0)
  end subroutine reject

  pure real(dp) function place_of(line, found) result(sought)
    !! The peak that a line was taken for; its own place if one that was taken for the same peak is refused already.
    type(damped_line), intent(in) :: line
    type(found_lines), intent(in) :: found
    sought = line%sought
    if (any(abs(found%rejected%sought - sought) <= 0)) sought = line%frequency
  end function place_of

end module bw_line_refusals
