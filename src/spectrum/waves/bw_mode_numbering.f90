module bw_mode_numbering
  !! Which peak is which mode. A ratio R fits many modes, each with its own α; all modes of a uniform beam lie on
  !! one curve ν² = c₁ α⁴ + c₀ with c₁ > 0 and c₀ ≤ 0 (Eq. 30, whatever h and ω). Two strong peaks taken as two
  !! modes give a curve; the curve that most peaks lie on numbers them. What lies off it is folded, or no mode.
  use bw_kinds, only: dp
  use bw_line_peaks, only: peak_type
  use bw_mode_ratio, only: alpha_of_ratio, mode_near
  implicit none (type, external)
  private
  public :: folded_mode, number_modes

  integer, parameter :: most_anchors = 6         !! strongest peaks that are tried as pairs
  integer, parameter :: highest_anchor = 50      !! mode
  integer, parameter :: highest_folded = 400     !! mode
  integer, parameter :: far = 26                 !! e^(−α/2) is below rounding: α(R) repeats, 4π further every 4 modes
  real(dp), parameter :: clear_position = 0.3_dp !! bins; peaks with larger errors number nothing
  real(dp), parameter :: clear_ratio = 0.05_dp   !! relative to 1 + |R|

  real(dp), parameter :: pi = acos(-1.0_dp)

  type, public :: curve_type
    !! ν² = slope α⁴ + start, ν in periods in the record.
    real(dp) :: slope = 0, slope_error = 0
    real(dp) :: start = 0
    integer :: support = 0                       !! peaks on it
    integer :: gaps = 0                          !! modes below the highest that have no peak
  end type curve_type

  type, public :: mode_type
    !! A peak as a mode.
    integer :: number = 0                        !! 0: none
    real(dp) :: alpha = 0, alpha_error = 0
    real(dp) :: square = 0, square_error = 0     !! ν² of the undamped mode and its error
  end type mode_type

contains

  subroutine number_modes(peaks, samples, modes, curve)
    !! Number the peaks; `curve%support` is 0 if that cannot be done.
    type(peak_type), intent(in) :: peaks(:)
    integer, intent(in) :: samples               !! in the record
    type(mode_type), intent(out) :: modes(:)     !! one for each peak
    type(curve_type), intent(out) :: curve
    type(mode_type), allocatable :: role(:, :)   !! every clear peak as every mode
    logical :: clear(size(peaks))
    integer, allocatable :: strong(:)
    integer :: i, j, k, m
    clear = is_clear(peaks)
    allocate (strong, source=strongest(peaks, clear))
    allocate (role(highest_anchor, size(peaks)))
    do i = 1, size(peaks)
      if (clear(i)) role(:, i) = [(as_mode(peaks(i), k), k=1, highest_anchor)]
    end do
    do i = 1, size(strong)
      do j = 1, size(strong)
        if (peaks(strong(i))%position >= peaks(strong(j))%position) cycle
        do k = 1, highest_anchor
          do m = k + 1, highest_anchor
            call try_curve(role(k, strong(i)), role(m, strong(j)), peaks, clear, role, modes, curve)
          end do
        end do
      end do
    end do
    if (curve%support == 2 .and. (curve%gaps > 0 .or. count(clear) > 2)) then  ! any two peaks lie on some curve
      call number_first_two(peaks, clear, strong, role, samples, modes, curve)
    end if
    if (curve%support > 0) then
      call fit_curve(modes, curve)
    else if (size(peaks) == 1 .and. count(clear) == 1) then
      modes(1) = as_mode(peaks(1), 1)            ! a line that stands alone is mode 1 if its ratio allows
    end if
  end subroutine number_modes

  subroutine number_first_two(peaks, clear, strong, role, samples, modes, curve)
    !! Modes 1 and 2 alone below the Nyquist frequency: the pair on whose curve all other clear peaks are folded modes.
    type(peak_type), intent(in) :: peaks(:)
    logical, intent(in) :: clear(:)
    integer, intent(in) :: strong(:)
    type(mode_type), intent(in) :: role(:, :)    !! (mode, peak)
    integer, intent(in) :: samples
    type(mode_type), intent(inout) :: modes(:)
    type(curve_type), intent(inout) :: curve
    integer :: i, j, k
    do i = 1, size(strong)
      do j = 1, size(strong)
        if (peaks(strong(i))%position >= peaks(strong(j))%position) cycle
        curve = curve_type()
        call try_curve(role(1, strong(i)), role(2, strong(j)), peaks, clear, role, modes, curve)
        if (curve%support /= 2) cycle
        call fit_curve(modes, curve)
        if (all(modes%number > 0 .or. .not. clear .or. &
          & [(folded_mode(peaks(k), curve, samples) > 0, k=1, size(peaks))])) return
      end do
    end do
    curve = curve_type()
    modes = mode_type()
  end subroutine number_first_two

  elemental logical function is_clear(peak)
    type(peak_type), intent(in) :: peak
    is_clear = peak%position_error < clear_position .and. peak%ratio_error < clear_ratio*(1 + abs(peak%ratio))
  end function is_clear

  pure function strongest(peaks, clear) result(chosen)
    type(peak_type), intent(in) :: peaks(:)
    logical, intent(in) :: clear(:)
    integer, allocatable :: chosen(:)
    integer :: i
    allocate (chosen, source=pack([(i, i=1, size(peaks))], &
      & clear .and. [(count(clear .and. peaks%strength > peaks(i)%strength) < most_anchors, i=1, size(peaks))]))
    if (size(chosen) > most_anchors) chosen = chosen(:most_anchors)
  end function strongest

  pure type(mode_type) function as_mode(peak, number) result(mode)
    !! The peak as that mode; number 0 if its ratio forbids it.
    type(peak_type), intent(in) :: peak
    integer, intent(in) :: number
    logical :: found
    call alpha_of_ratio(peak%ratio, peak%ratio_error, number, mode%alpha, mode%alpha_error, found)
    if (found) mode%number = number
    mode%square = peak%position**2 + (peak%growth/(2*pi))**2
    mode%square_error = (2*peak%position + peak%position_error)*peak%position_error &
      & + 2*abs(peak%growth)/(2*pi)*peak%position_error + 4*epsilon(1.0_dp)*mode%square
  end function as_mode

  subroutine try_curve(low, high, peaks, clear, role, modes, curve)
    !! Keep the curve through two modes if more peaks lie on it, or as many and fewer modes are without a peak.
    type(mode_type), intent(in) :: low, high
    type(peak_type), intent(in) :: peaks(:)
    logical, intent(in) :: clear(:)
    type(mode_type), intent(in) :: role(:, :)    !! (mode, peak)
    type(mode_type), intent(inout) :: modes(:)
    type(curve_type), intent(inout) :: curve
    type(mode_type) :: trial_modes(size(modes))
    type(curve_type) :: trial
    integer :: i
    if (low%number == 0 .or. high%number == 0) return
    trial%slope = (high%square - low%square)/(high%alpha**4 - low%alpha**4)
    trial%start = low%square - trial%slope*low%alpha**4
    if (trial%slope <= 0 .or. trial%start > tolerance(0.0_dp, low, high, trial%slope)) return
    do i = 1, size(peaks)
      if (clear(i)) trial_modes(i) = mode_on_curve(peaks(i), role(:, i), low, high, trial)
    end do
    trial%support = count(trial_modes%number > 0)
    trial%gaps = maxval(trial_modes%number) - trial%support - count(peaks%at_edge)  ! a mode may grow, or hide at 0
    if (trial%gaps > trial%support) return
    if (trial%support < curve%support) return
    if (trial%support == curve%support .and. trial%gaps >= curve%gaps) return
    curve = trial
    modes = trial_modes
  end subroutine try_curve

  pure real(dp) function tolerance(power, low, high, slope)
    !! How far the curve through two modes may err at α⁴ = power.
    real(dp), intent(in) :: power, slope
    type(mode_type), intent(in) :: low, high
    real(dp) :: share
    share = (high%alpha**4 - power)/(high%alpha**4 - low%alpha**4)
    tolerance = abs(share)*curve_error(low, slope) + abs(1 - share)*curve_error(high, slope)
  end function tolerance

  elemental real(dp) function curve_error(mode, slope)
    !! Error of a mode's ν² − slope·α⁴.
    type(mode_type), intent(in) :: mode
    real(dp), intent(in) :: slope
    curve_error = mode%square_error + slope*((mode%alpha + mode%alpha_error)**4 - mode%alpha**4)
  end function curve_error

  pure type(mode_type) function mode_on_curve(peak, role, low, high, curve) result(mode)
    !! The mode that the peak is, if its α and its frequency agree with the curve within their errors.
    type(peak_type), intent(in) :: peak
    type(mode_type), intent(in) :: role(:)       !! the peak as each of the first modes
    type(mode_type), intent(in) :: low, high
    type(curve_type), intent(in) :: curve
    real(dp) :: power
    integer :: k
    power = max(0.0_dp, (peak%position**2 - curve%start)/curve%slope)
    k = mode_near(sqrt(sqrt(power)))
    if (k <= size(role)) then
      mode = role(k)
    else
      mode = as_mode(peak, k)
    end if
    if (mode%number == 0) return
    if (abs(mode%square - curve%start - curve%slope*mode%alpha**4) > &
      & curve_error(mode, curve%slope) + tolerance(mode%alpha**4, low, high, curve%slope)) mode%number = 0
  end function mode_on_curve

  pure subroutine fit_curve(modes, curve)
    !! Straight line ν²(α⁴) through all modes, weighted by their errors; its slope's error if all errors conspire.
    type(mode_type), intent(in) :: modes(:)
    type(curve_type), intent(inout) :: curve
    real(dp), allocatable :: x(:), y(:), e(:), w(:), share(:)
    logical :: used(size(modes))
    used = modes%number > 0
    allocate (x, source=pack(modes%alpha, used)**4)
    allocate (y, source=pack(modes%square, used))
    allocate (e, source=pack(curve_error(modes, curve%slope), used))
    allocate (w, source=(minval(e)/e)**2)
    w = w/sum(w)
    allocate (share, source=w*(x - sum(w*x)))
    share = share/sum(share*x)
    curve%slope = sum(share*(y - sum(w*y)))
    curve%start = sum(w*y) - curve%slope*sum(w*x)
    curve%slope_error = sum(abs(share)*e) + 8*epsilon(1.0_dp)*curve%slope
  end subroutine fit_curve

  pure integer function folded_mode(peak, curve, samples) result(number)
    !! The mode above half the sampling rate that folds back onto the peak, 0 if none is found.
    type(peak_type), intent(in) :: peak
    type(curve_type), intent(in) :: curve
    integer, intent(in) :: samples
    type(mode_type) :: as(far + 3), mode
    real(dp) :: position, error
    integer :: k, lowest
    number = 0
    if (.not. is_clear(peak)) return
    as = [(as_mode(peak, k), k=1, far + 3)]
    lowest = mode_near(sqrt(sqrt(max(0.0_dp, (0.5_dp*samples)**2 - curve%start)/curve%slope)))
    do k = lowest, highest_folded
      mode = as(min(k, far + modulo(k - far, 4)))
      if (mode%number == 0) cycle
      mode%alpha = mode%alpha + (k - mode%number)*pi
      position = sqrt(max(0.0_dp, curve%start + curve%slope*mode%alpha**4))
      error = (curve%slope_error*mode%alpha**4 + curve_error(mode, curve%slope))/(2*max(position, 1.0_dp)) &
        & + peak%position_error
      if (error > clear_position) cycle
      position = abs(position - samples*anint(position/samples))
      if (abs(position - peak%position) < error) then
        number = k
        return
      end if
    end do
  end function folded_mode

end module bw_mode_numbering
