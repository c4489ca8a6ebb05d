module bw_tapered_residual
  !! The residual of a record after lines are subtracted, and the significant peaks in it.
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
  use bw_constants, only: pi
  use bw_fourier, only: transform_in_place
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_model, only: add_lines
  use bw_monitor, only: monitor_type, stops
  use bw_order, only: local_maxima, vertex
  use bw_tapered_line, only: line_in_record, main_lobe, position_of, sidelobe, strength_of
  implicit none (type, external)
  private
  public :: find_residual, peak_lines, plain_bins, rounding_of, strength, visible_peaks

  integer, parameter :: bins_for_noise = 100   !! with fewer bins, lines may fill the quietest tenth
  integer, parameter :: most_peaks = 64        !! examined at a time
  real(dp), parameter, public :: chance = 8    !! standard deviations that noise does not reach in 10¹² bins
  real(dp), parameter :: faintest = 1.0e-13_dp !! relative to the record's peak; rounded phases make lines of up to 1e-14
  real(dp), parameter :: guard = 4             !! factor by which a peak must exceed the sidelobes of stronger ones

  type, public :: residual_type
    integer :: count = 0                       !! samples in the record
    complex(dp), allocatable :: tapered(:, :)  !! transform with the taper sin⁶(πj/N), (0:N/2, S)
    complex(dp), allocatable :: plain(:, :)    !! transform without taper, (0:N/2, S)
    real(dp) :: noise = 0                      !! standard deviation of a real number of `tapered`
    real(dp) :: highest = 0                    !! largest absolute value of the record's samples
    real(dp) :: threshold = 0                  !! smaller values of |tapered| are no line
  end type residual_type

contains

  subroutine find_residual(record, lines, residual, monitor)
    !! Transform the residual of the record after these lines, and estimate its noise. The lines are subtracted in the memory of
    !! the transforms, to save memory with long records.
    real(dp), intent(in) :: record(0:, :)      !! (N, S)
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(inout), target :: residual   !! empty, or of the same record; undefined after a stop request
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), pointer, contiguous :: history(:, :), tapered_history(:, :) ! without taper and with it
    real(dp) :: rounding, largest
    integer :: i, n, s, sensors
    n = size(record, 1)
    sensors = size(record, 2)
    residual%count = n
    if (.not. allocated(residual%plain)) allocate (residual%tapered(0:n/2, sensors), residual%plain(0:n/2, sensors))
    call c_f_pointer(c_loc(residual%plain), history, [2*(n/2 + 1), sensors])
    call c_f_pointer(c_loc(residual%tapered), tapered_history, [2*(n/2 + 1), sensors])
    tapered_history(:n, :) = record
    residual%highest = maxval(abs(record))
    call apply_taper(tapered_history(:n, :))
    rounding = epsilon(1.0_dp)*maxval([(norm2(tapered_history(:n, s)), s=1, sensors)])
    largest = maxval(abs(tapered_history(:n, :)))
    history(:n, :) = record
    do i = 1, size(lines)
      if (stops(monitor)) return
      call add_lines(reshape([1, 0, 1, n], [2, 2]), lines(i:i), -1.0_dp, history)
    end do
    call copy(history(:n, :), tapered_history(:n, :)) ! an assignment of pointers would need a third array
    call apply_taper(tapered_history(:n, :))
    do s = 1, sensors
      if (stops(monitor)) return
      call transform_in_place(n, residual%tapered(:, s))
      call transform_in_place(n, residual%plain(:, s))
    end do
    residual%noise = max(rounding, quiet_level(strength(residual)))
    residual%threshold = max(chance*residual%noise, chance*rounding_of(lines, n), faintest*largest*n*main_lobe/2)
  end subroutine find_residual

  pure real(dp) function rounding_of(lines, count)
    !! The contribution of rounding to a bin: samples of the strongest line are rounded, and its frequency is rounded to a
    !! quarter of the spacing of numbers.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count
    rounding_of = epsilon(1.0_dp)*count*main_lobe/2*maxval([0.0_dp, (1 + position_of(lines, count)/4)*strength_of(lines, count)])
  end function rounding_of

  pure subroutine copy(from, to)
    !! Copy between arrays that do not overlap.
    real(dp), intent(in) :: from(:, :)
    real(dp), intent(inout) :: to(:, :)
    to = from
  end subroutine copy

  pure subroutine apply_taper(samples)
    !! Multiply all sensors by the taper sin⁶(πj/N), which is symmetric to the bit.
    real(dp), intent(inout) :: samples(0:, :)  !! (N, S)
    real(dp) :: taper
    integer :: j, n
    n = size(samples, 1)
    samples(0, :) = 0
    do j = 1, n/2
      taper = sin(pi*j/n)**6
      samples(j, :) = taper*samples(j, :)
      if (2*j < n) samples(n - j, :) = taper*samples(n - j, :)
    end do
  end subroutine apply_taper

  pure function strength(residual) result(value)
    !! The norm of all sensors' tapered transforms in each bin, (0:N/2).
    type(residual_type), intent(in) :: residual
    real(dp) :: value(0:ubound(residual%tapered, 1))
    value = norm2(abs(residual%tapered), dim=2)
  end function strength

  pure real(dp) function quiet_level(value)
    !! The standard deviation of the noise in `value`, estimated from its quietest tenth; 0 if there are too few bins for that.
    !! The tenth quantile, found by bisection, of the norm of four normal numbers is 1.03 standard deviations.
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
    real(dp) :: value(0:ubound(residual%tapered, 1))
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
      !! The sidelobes of the peaks found so far, and of their mirror images, in this bin.
      integer, intent(in) :: bin
      leakage = sum(value(peak)*(sidelobe(real(bin - peak, dp)) + sidelobe(real(bin + peak, dp)) &
        & + sidelobe(real(residual%count - bin - peak, dp))))
    end function leakage

  end function visible_peaks

  pure function plain_bins(residual, first, last) result(image)
    !! The transform without taper at bins first … last, which may extend beyond 0 and the Nyquist frequency.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: first, last
    complex(dp) :: image(first:last, size(residual%plain, 2))
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
    !! A line without amplitude at each peak; its offset is that of a parabola through the logarithms of three bins.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: peaks(:)
    type(line_type) :: lines(size(peaks))
    real(dp) :: value(-1:1), offset
    integer :: i, m
    do i = 1, size(peaks)
      offset = 0
      if (peaks(i) > 0 .and. peaks(i) < ubound(residual%tapered, 1)) then
        value = [(norm2(abs(residual%tapered(peaks(i) + m, :))), m=-1, 1)]
        offset = vertex(value)
      end if
      lines(i) = line_in_record(peaks(i) + offset, 0.0_dp, residual%count)
    end do
  end function peak_lines

end module bw_tapered_residual
