module bw_recorded_sensors
  !! What was found of lines at separated and distinct sensors, turned into what it is at the sensors of the record.
  use bw_common_noise, only: parts_of
  use bw_distinct_sensors, only: distinct_type
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_line_names, only: believed_line
  use bw_ordinates, only: ordinates_type
  use bw_whitening, only: no_whitening, whitening_type
  implicit none (type, external)
  private
  public :: mix_again, repeat_sensors

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter, public :: undetermined = 1.0e100_dp  !! a bound where the record does not tell
  real(dp), parameter :: no_level = tiny(1.0_dp)*1.0e50_dp  !! of the noise of a sensor that has none

contains

  pure subroutine mix_again(found)
    !! Turn lines, offsets, slopes and noise of what the sensors were separated into back into those of the sensors.
    type(found_lines), intent(inout) :: found
    real(dp), allocatable :: level(:, :)
    integer :: k, s
    if (.not. allocated(found%mixture%mixed)) return
    associate (mixed => found%mixture%mixed, ordinates => found%ordinates)
      do k = 1, size(found%lines)
        found%lines(k)%amplitude = [(sum(parts_of(found%mixture, s, size(mixed, 2))*found%lines(k)%amplitude), s=1, size(mixed, 1))]
      end do
      found%still = matmul(found%still, transpose(mixed))
      allocate (level(0:ubound(ordinates%noise%level, 1), size(mixed, 1)))
      level(:, :) = matmul(ordinates%noise%level, transpose(mixed**2))
      call move_alloc(level, ordinates%noise%level)
      ordinates%shape = ordinates%shape*size(mixed, 1)/size(mixed, 2)
      ordinates%deviation = sqrt(matmul(mixed**2, ordinates%deviation**2))
    end associate
    deallocate (found%mixture%mixed)
  end subroutine mix_again

  pure subroutine repeat_sensors(distinct, found, believed)
    !! Give lines, offset, slope and noise to the sensors that are multiples of others. Constant ones have an offset, and tell
    !! nothing of amplitudes.
    type(distinct_type), intent(in) :: distinct
    type(found_lines), intent(inout) :: found
    type(believed_line), intent(inout) :: believed(:)  !! correlations of their noise are those of the sensors that were kept
    type(whitening_type) :: whitening(size(distinct%place))
    complex(dp), allocatable :: correlation(:, :)
    integer :: k, s
    found%own = [(any(distinct%kept == s), s=1, size(distinct%place))]
    if (all(found%own)) return
    whitening = no_whitening(size(whitening))
    whitening%lost = maxval(found%whitening%lost)
    do s = 1, size(whitening)
      if (distinct%place(s) > 0) whitening(s) = found%whitening(distinct%place(s))
    end do
    found%whitening = whitening
    do k = 1, size(found%lines)
      found%lines(k)%amplitude = [(repeated(found%lines(k)%amplitude, s), s=1, size(whitening))]
    end do
    found%still = reshape([(still_of(s), s=1, size(whitening))], [2, size(whitening)])
    found%deviation = scaled(found%deviation, 0.0_dp)
    found%ordinates%deviation = scaled(found%ordinates%deviation, 0.0_dp)
    call repeat_noise(distinct, found%ordinates)
    do k = 1, size(believed)
      associate (line => believed(k))
        line%amplitude = [(repeated(line%amplitude, s), s=1, size(whitening))]
        line%amplitude_bound = scaled(line%amplitude_bound, undetermined)
        line%amplitude_noise = scaled(line%amplitude_noise, undetermined)
        line%phase_bound = [(merge(line%phase_bound(max(distinct%place(s), 1)), pi, distinct%place(s) > 0), s=1, size(whitening))]
        if (.not. allocated(line%noise_correlation)) cycle
        allocate (correlation(size(whitening), size(whitening)), source=(0.0_dp, 0.0_dp))
        correlation(distinct%kept, distinct%kept) = line%noise_correlation
        call move_alloc(correlation, line%noise_correlation)
      end associate
    end do

  contains

    pure complex(dp) function repeated(amplitude, s)
      complex(dp), intent(in) :: amplitude(:)
      integer, intent(in) :: s
      repeated = 0
      if (distinct%place(s) > 0) repeated = distinct%factor(s)*amplitude(distinct%place(s))
    end function repeated

    pure function scaled(deviation, none)
      !! Deviations, and what constant sensors have.
      real(dp), intent(in) :: deviation(:), none
      real(dp) :: scaled(size(distinct%place))
      integer :: i
      scaled = none
      do i = 1, size(scaled)
        if (distinct%place(i) > 0) scaled(i) = min(abs(distinct%factor(i))*deviation(distinct%place(i)), undetermined)
      end do
    end function scaled

    pure function still_of(s)
      integer, intent(in) :: s
      real(dp) :: still_of(2)
      still_of = [distinct%constant(s), 0.0_dp]
      if (distinct%place(s) > 0) still_of = distinct%factor(s)*found%still(:, distinct%place(s))
    end function still_of

  end subroutine repeat_sensors

  pure subroutine repeat_noise(distinct, ordinates)
    !! Give levels to all sensors; as to how many have independent noise, they are as those were.
    type(distinct_type), intent(in) :: distinct
    type(ordinates_type), intent(inout) :: ordinates
    real(dp), allocatable :: level(:, :)
    integer :: s
    allocate (level(0:ubound(ordinates%noise%level, 1), size(distinct%place)), source=no_level)
    do s = 1, size(distinct%place)
      if (distinct%place(s) > 0) level(:, s) = max(distinct%factor(s)**2*ordinates%noise%level(:, distinct%place(s)), no_level)
    end do
    ordinates%shape = ordinates%shape*size(distinct%place)/size(distinct%kept)
    call move_alloc(level, ordinates%noise%level)
  end subroutine repeat_noise

end module bw_recorded_sensors
