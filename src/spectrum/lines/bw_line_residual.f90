module bw_line_residual
  !! What is left of two histories when lines are taken out, and which peaks still stand out of it.
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
  use bw_fourier, only: transform_in_place
  use bw_kinds, only: dp
  use bw_line, only: line_type, main_lobe, points, sidelobe, subtract_line
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private
  public :: find_residual, peak_lines, plain_bins, strength, visible_peaks

  integer, parameter :: bins_for_noise = 100   !! with fewer bins, lines may fill the quietest tenth
  integer, parameter :: most_peaks = 64        !! taken up at a time
  real(dp), parameter :: chance = 8            !! noise does not reach so many standard deviations in 10¹² bins
  real(dp), parameter :: faintest = 1.0e-13_dp !! of the record's peak; rounded phases make lines of up to 1e-14
  real(dp), parameter :: guard = 4             !! a peak stands out of so many times the sidelobes of stronger ones
  real(dp), parameter :: pi = acos(-1.0_dp)

  type, public :: residual_type
    integer :: count = 0                       !! samples in the record
    complex(dp), allocatable :: windowed(:, :) !! transform with the window sin⁶(πj/N), (0:N/2, points)
    complex(dp), allocatable :: plain(:, :)    !! transform without, (0:N/2, points)
    real(dp) :: noise = 0                      !! standard deviation of a real number of `windowed`
    real(dp) :: threshold = 0                  !! smaller values of |windowed| are no line
  end type residual_type

contains

  subroutine find_residual(record, lines, residual, monitor)
    !! Transform what the lines leave of the record, and judge its noise. The lines are subtracted in the memory of the
    !! transforms, so that a long record is not stored more often than it must be.
    real(dp), intent(in) :: record(0:, :)      !! (N, points)
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(inout), target :: residual   !! empty, or of the same record; of no use where the monitor stops
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), pointer, contiguous :: left(:, :), seen(:, :)  ! without window and with it
    real(dp) :: rounding, largest
    integer :: i, n, p
    n = size(record, 1)
    residual%count = n
    if (.not. allocated(residual%plain)) allocate (residual%windowed(0:n/2, points), residual%plain(0:n/2, points))
    call c_f_pointer(c_loc(residual%plain), left, [2*(n/2 + 1), points])
    call c_f_pointer(c_loc(residual%windowed), seen, [2*(n/2 + 1), points])
    seen(:n, :) = record
    call apply_window(seen(:n, :))
    rounding = epsilon(1.0_dp)*maxval([(norm2(seen(:n, p)), p=1, points)])
    largest = maxval(abs(seen(:n, :)))
    left(:n, :) = record
    do i = 1, size(lines)
      if (stops(monitor)) return
      call subtract_line(lines(i), left(:n, :))
    end do
    call copy(left(:n, :), seen(:n, :))        ! an assignment of pointers would go through a third array
    call apply_window(seen(:n, :))
    do p = 1, points
      if (stops(monitor)) return
      call transform_in_place(n, residual%windowed(:, p))
      call transform_in_place(n, residual%plain(:, p))
    end do
    residual%noise = max(rounding, quiet_level(strength(residual)))
    residual%threshold = max(chance*residual%noise, faintest*largest*n*main_lobe/2)
  end subroutine find_residual

  pure subroutine copy(from, to)
    !! Copy between arrays that do not overlap.
    real(dp), intent(in) :: from(:, :)
    real(dp), intent(inout) :: to(:, :)
    to = from
  end subroutine copy

  pure subroutine apply_window(samples)
    !! Multiply both histories by the window sin⁶(πj/N), which is the same from both ends to the bit.
    real(dp), intent(inout) :: samples(0:, :)  !! (N, points)
    real(dp) :: window
    integer :: j, n
    n = size(samples, 1)
    samples(0, :) = 0
    do j = 1, n/2
      window = sin(pi*j/n)**6
      samples(j, :) = window*samples(j, :)
      if (2*j < n) samples(n - j, :) = window*samples(n - j, :)
    end do
  end subroutine apply_window

  pure function strength(residual) result(value)
    !! The length of both histories' windowed transforms together in each bin, (0:N/2).
    type(residual_type), intent(in) :: residual
    real(dp) :: value(0:ubound(residual%windowed, 1))
    value = sqrt(abs(residual%windowed(:, 1))**2 + abs(residual%windowed(:, 2))**2)
  end function strength

  pure real(dp) function quiet_level(value)
    !! The standard deviation of the noise in `value`, judged by its quietest tenth; 0 where there are too few bins to tell.
    !! The tenth quantile, found by bisection, of the length of four normal numbers is 1.03 standard deviations.
    real(dp), intent(in) :: value(:)
    real(dp) :: low, high, middle
    integer :: i
    quiet_level = 0
    if (size(value) < bins_for_noise) return
    low = 0
    high = maxval(value)
    do i = 1, 80
      middle = merge((low + high)/2, sqrt(low)*sqrt(high), low == 0)
      if (low == 0) middle = high/1024
      if (10*count(value < middle) > size(value)) then
        high = middle
      else
        low = middle
      end if
      if (high <= 1.05_dp*low .or. high == 0) exit
    end do
    quiet_level = high/1.03_dp
  end function quiet_level

  function visible_peaks(residual) result(peak)
    !! The bins of the peaks that are neither noise nor a sidelobe of a stronger peak, the strongest first.
    type(residual_type), intent(in) :: residual
    integer, allocatable :: peak(:)
    real(dp) :: value(0:ubound(residual%windowed, 1))
    integer, allocatable :: candidate(:)
    integer :: i, best
    value = strength(residual)
    allocate (candidate, source=local_maxima(value, residual%threshold))
    allocate (peak(0))
    do i = 1, min(size(candidate), 4*most_peaks)
      best = maxloc(value(candidate), dim=1)
      associate (bin => candidate(best))
        if (value(bin) > guard*leakage(bin)) peak = [peak, bin]
      end associate
      candidate = [candidate(:best - 1), candidate(best + 1:)]
      if (size(peak) == most_peaks) exit
    end do

  contains

    pure real(dp) function leakage(bin)
      !! The sidelobes that the peaks found so far and their mirror images have in this bin.
      integer, intent(in) :: bin
      leakage = sum(value(peak)*(sidelobe(real(bin - peak, dp)) + sidelobe(real(bin + peak, dp)) &
        & + sidelobe(real(residual%count - bin - peak, dp))))
    end function leakage

  end function visible_peaks

  pure function local_maxima(value, threshold) result(bins)
    !! The bins above the threshold that are not lower than their neighbours.
    real(dp), intent(in) :: value(0:), threshold
    integer, allocatable :: bins(:)
    logical :: high(0:size(value) - 1)
    integer :: last, i
    last = size(value) - 1
    high = value > threshold
    high(1:) = high(1:) .and. value(1:) >= value(:last - 1)
    high(:last - 1) = high(:last - 1) .and. value(:last - 1) > value(1:)
    allocate (bins, source=pack([(i, i=0, last)], high))
  end function local_maxima

  pure function plain_bins(residual, first, last) result(image)
    !! The transform without window at bins first … last, which may lie beyond 0 and the Nyquist frequency.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: first, last
    complex(dp) :: image(first:last, points)
    integer :: m, k
    do m = first, last
      k = modulo(m, residual%count)
      if (2*k <= residual%count) then
        image(m, :) = residual%plain(k, :)
      else
        image(m, :) = conjg(residual%plain(residual%count - k, :))
      end if
    end do
  end function plain_bins

  pure function peak_lines(residual, peaks) result(lines)
    !! A line without amplitude at each peak; its offset comes from a parabola through the logarithms of three bins.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: peaks(:)
    type(line_type) :: lines(size(peaks))
    real(dp) :: value(-1:1)
    integer :: i, m
    lines%bin = peaks
    do i = 1, size(peaks)
      if (peaks(i) == 0 .or. peaks(i) == ubound(residual%windowed, 1)) cycle
      value = [(norm2(abs(residual%windowed(peaks(i) + m, :))), m=-1, 1)]
      if (any(value <= 0)) cycle
      value = log(value)
      lines(i)%offset = (value(1) - value(-1))/max(2*(2*value(0) - value(1) - value(-1)), 1.0_dp)
      lines(i)%offset = max(-0.5_dp, min(0.5_dp, lines(i)%offset))
    end do
  end function peak_lines

end module bw_line_residual
