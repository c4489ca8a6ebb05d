module bw_line_candidates
  !! Where a record may have a further line: peaks of what the lines that are there leave, and lines that are gone long before the
  !! record ends.
  use bw_damped_line, only: bend_reach, damped_line
  use bw_drift, only: drift_gain, drift_taken
  use bw_found_lines, only: beside_drift, drift_reach, found_lines
  use bw_kinds, only: dp
  use bw_line_bands, only: own_rows, weight_of
  use bw_order, only: local_maxima, vertex
  use bw_ordinates, only: ordinates_type
  use bw_samples, only: centre_of, samples_type, span_of
  use bw_short_lines, only: short_lines
  implicit none (type, external)
  private
  public :: candidates, short_candidates

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: most_at_once = 64, most_around = 3  !! new lines of a round, and of a place
  real(dp), parameter :: around = 8              !! bins that a place reaches to either side
  real(dp), parameter :: guard = 4               !! times the leakage of stronger peaks
  real(dp), parameter :: narrowest = 0.4_dp      !! bins; an undamped line leaks 1/(πd)² of its power
  real(dp), parameter :: beside = 0.7_dp         !! bins within which a place is the same
  real(dp), parameter :: most_reach = 4          !! half widths of a short line, in which one that drifts leaves something, and
                                                 !! rejected ones are the same
  real(dp), parameter :: undescribed = 0.01_dp   !! of what a drift takes, that may be left beside it

contains

  function candidates(samples, found, ordinates, threshold, distance) result(fresh)
    !! New lines at the peaks that noise does not explain, nor the leakage of stronger peaks, nor a drift of a line, and that have
    !! not been rejected.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    type(ordinates_type), intent(in) :: ordinates
    real(dp), intent(in) :: threshold
    real(dp), intent(in) :: distance             !! bins from other lines that new ones keep
    type(damped_line), allocatable :: fresh(:)
    integer, allocatable :: peak(:), taken(:)
    real(dp) :: leakage, place, bins
    integer :: i, j, best
    allocate (fresh(0), taken(0))
    associate (total => ordinates%total, length => ordinates%length)
      bins = span_of(samples)/length
      peak = local_maxima(total, threshold)
      peak = pack(peak, peak > 0 .and. peak < ubound(total, 1))
      do i = 1, min(size(peak), 4*most_at_once)
        best = maxloc(total(peak), dim=1)
        associate (m => peak(best))
          place = m + vertex(total(m - 1:m + 1))
          leakage = 0
          do j = 1, size(taken)
            leakage = leakage + total(taken(j))/(1 + ((m - taken(j))*bins/width(total, taken(j), bins))**2) &
              & + total(taken(j))/(1 + ((m + taken(j))*bins/width(total, taken(j), bins))**2)
          end do
          if (total(m) > guard*leakage) then
            taken = [taken, m]
            if (count(abs(fresh%frequency - place/length)*span_of(samples) < around) < most_around) then
              if (is_new(place/length, total(m))) fresh = [fresh, line_at(samples, place/length, width(total, m, bins))]
            end if
          end if
        end associate
        peak = [peak(:best - 1), peak(best + 1:)]
        if (size(fresh) == most_at_once) exit
      end do
    end associate

  contains

    logical function is_new(frequency, ordinate)
      !! Whether a peak is none of a rejected line, nor beside a line in whose peak a drift would take more.
      real(dp), intent(in) :: frequency, ordinate
      is_new = all(abs(found%rejected%frequency - frequency)*span_of(samples) > &
        & merge(drift_reach, beside, found%rejected%reason == beside_drift)) &
        & .and. all(abs(found%rejected%sought - frequency)*span_of(samples) > beside) &
        & .and. all(abs(found%lines%frequency - frequency)*span_of(samples) >= distance)
      if (is_new) is_new = .not. is_drift(samples, found, frequency, ordinate)
    end function is_new

  end function candidates

  logical function is_drift(samples, found, frequency, ordinate)
    !! Whether a peak is beside a line whose drift would take more off the squares than a line at the peak, or has taken so much
    !! more that this is what no drift of a few powers of time describes.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: frequency, ordinate
    real(dp), allocatable :: rows(:, :), weight(:)
    type(damped_line), allocatable :: own(:)
    integer :: i, j
    is_drift = .false.
    do i = 1, size(found%bands)
      associate (band => found%bands(i))
        own = found%lines(band%member)
        do j = 1, size(own)
          if (abs(own(j)%frequency - frequency)*span_of(samples) > drift_reach + broadened(own(j))) cycle
          rows = own_rows(samples, found%lines, found%still, band)
          weight = weight_of(found%ordinates%noise, band, size(samples%value, 2))
          is_drift = 2*ordinate < drift_gain(samples, band, rows, weight, own, j)
          if (is_drift) return
          if (own(j)%powers > 1) is_drift = 2*ordinate < undescribed*drift_taken(samples, band, rows, weight, own, j)
          if (is_drift) return
        end do
      end associate
    end do

  contains

    real(dp) function broadened(line)
      !! Bins that a line's drift reaches to either side.
      type(damped_line), intent(in) :: line
      complex(dp) :: reach
      reach = bend_reach(line, centre_of(samples))
      broadened = reach%im/pi
    end function broadened

  end function is_drift

  pure real(dp) function width(total, m, bins)
    !! Half the width of a peak at half its height, in bins, not less than that of an undamped line.
    real(dp), intent(in) :: total(0:)
    integer, intent(in) :: m
    real(dp), intent(in) :: bins                 !! between ordinates
    integer :: low, high
    do low = m, 1, -1
      if (2*total(low) < total(m)) exit
    end do
    do high = m, size(total) - 2
      if (2*total(high) < total(m)) exit
    end do
    width = max(narrowest, (high - low)*bins/2 - narrowest)
  end function width

  pure function line_at(samples, frequency, half_width) result(line)
    !! A line at a peak, with the decay that its width tells: the power of a decaying line is half at 2π(f − f₀) = decay.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: frequency
    real(dp), intent(in) :: half_width           !! bins
    type(damped_line) :: line
    line%frequency = frequency
    line%sought = frequency
    line%decay = max(1.0_dp, 2*pi*(half_width - narrowest))/span_of(samples)
    allocate (line%amplitude(size(samples%value, 2)))
    line%amplitude = 0
  end function line_at

  function short_candidates(samples, found, false_alarm) result(fresh)
    !! A new line that is gone long before the record ends, or grows as fast, if one stands out of the noise, has not been
    !! rejected, and is not beside a line that drifts, of which anything may be left.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: false_alarm
    type(damped_line), allocatable :: fresh(:)
    real(dp) :: reach
    integer :: k
    fresh = short_lines(samples, found%lines, found%still, found%ordinates%shape, false_alarm)
    if (size(fresh) == 0) return
    fresh%sought = fresh%frequency
    reach = abs(fresh(1)%decay)/(2*pi)
    if (any(abs(found%rejected%frequency - fresh(1)%frequency) < most_reach*reach .or. &
      & abs(found%rejected%sought - fresh(1)%sought)*span_of(samples) < beside)) fresh = fresh(2:)
    do k = 1, size(found%lines)
      if (size(fresh) == 0) exit
      if (abs(found%lines(k)%frequency - fresh(1)%frequency) < drift_reach/span_of(samples) &
        & + merge(most_reach*reach, 0.0_dp, found%lines(k)%powers > 1)) fresh = fresh(2:)
    end do
  end function short_candidates

end module bw_line_candidates
