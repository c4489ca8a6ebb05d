module bw_result_lines
  !! The lines of a record from its finished result.
  use bw_measured_state, only: state_lines
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_netcdf_reading, only: all_is_well, close_netcdf, find_variable, netcdf_dimension, netcdf_variable, open_netcdf, &
    read_dimensions, read_numbers, read_variable, status_text
  use bw_file_rows, only: quantities
  implicit none (type, external)
  private
  public :: read_result_lines

  real(dp), parameter :: least_error = 1.0e-12_dp     !! relative, of a frequency: the accuracy of modes
  real(dp), parameter :: least_decay_error = 1.0e-9_dp   !! of a decay, relative to the frequency

  type, public :: result_lines
    !! The lines of one case.
    type(state_lines) :: lines
    real(dp), allocatable :: angular_frequency(:), error(:)   !! of the damped line and half its interval [rad/s], (lines)
    real(dp), allocatable :: decay_error(:)      !! half its interval [1/s], (lines)
    integer, allocatable :: status(:)            !! bits of `status_words`, (lines)
  end type result_lines

contains

  subroutine read_result_lines(path, quantile, cases, error)
    !! Read the lines of all cases of a result.
    character(*), intent(in) :: path
    real(dp), intent(in) :: quantile             !! how many standard deviations half an interval is
    type(result_lines), allocatable, intent(out) :: cases(:)
    type(error_type), allocatable, intent(out) :: error
    real(dp), allocatable, dimension(:, :, :) :: frequency, frequency_error, decay, decay_error, status
    real(dp), allocatable, dimension(:, :, :) :: amplitude, amplitude_bound, phase, place, quantity
    real(dp), allocatable, dimension(:, :, :) :: constant_real, constant_imag, constant_error
    logical :: placed
    integer, allocatable :: known(:)
    integer :: file, problem, c, k, n, s
    call open_netcdf(path, file, problem)
    call read_block(file, 'measured_angular_frequency', frequency, problem)
    call read_block(file, 'measured_angular_frequency_error', frequency_error, problem)
    call read_block(file, 'measured_decay_rate', decay, problem)
    call read_block(file, 'measured_decay_rate_error', decay_error, problem)
    call read_block(file, 'peak_status', status, problem)
    if (problem /= all_is_well) then
      call fail(error, status_bad_file, path//': its lines cannot be read: '//status_text(problem))
      return
    end if
    call read_block(file, 'measured_amplitude', amplitude, problem)
    call read_block(file, 'measured_amplitude_bound', amplitude_bound, problem)
    call read_block(file, 'measured_phase', phase, problem)
    call read_block(file, 'point_position', place, problem)
    call read_block(file, 'sensor_quantity', quantity, problem)
    placed = problem == all_is_well
    if (placed) placed = size(place) > 1 .and. all(quantity == quantity(1, 1, 1))    ! else they do not measure shapes
    if (find_variable(file, 'measured_modal_constant_error') >= 0) then
      call read_block(file, 'measured_modal_constant_real', constant_real, problem)
      call read_block(file, 'measured_modal_constant_imag', constant_imag, problem)
      call read_block(file, 'measured_modal_constant_error', constant_error, problem)
    end if
    call close_netcdf(file)
    allocate (cases(size(frequency, 2)))
    do c = 1, size(cases)
      n = count(.not. is_missing(frequency(:, c, 1)))
      associate (one => cases(c))
        one%angular_frequency = frequency(:n, c, 1)
        one%error = frequency_error(:n, c, 1)
        one%decay_error = decay_error(:n, c, 1)
        one%status = nint(status(:n, c, 1))
        one%lines%decay = decay(:n, c, 1)
        one%lines%frequency = hypot(one%angular_frequency, one%lines%decay)
        one%lines%deviation = [(max(least_error*frequency(k, c, 1), frequency_error(k, c, 1)/quantile), k=1, n)]
        one%lines%decay_deviation = [(max(least_decay_error*frequency(k, c, 1), decay_error(k, c, 1)/quantile), k=1, n)]
        if (allocated(amplitude)) one%lines%strength = [(norm2(amplitude(k, :, c)), k=1, n)]
        if (allocated(constant_error) .and. allocated(place) .and. n > 0) then
          known = pack([(s, s=1, size(place))], .not. any(is_missing(constant_error(:n, :, c)), dim=1))
          one%lines%over_blow = size(known) > 0 .and. .not. any(is_missing(place))
          if (one%lines%over_blow) then
            one%lines%points = place(known, 1, 1)
            one%lines%sensor = known
            one%lines%amplitude = transpose(cmplx(constant_real(:n, known, c), constant_imag(:n, known, c), dp))
            one%lines%amplitude_deviation = transpose(constant_error(:n, known, c))/quantile
            cycle
          end if
        end if
        if (.not. placed .or. n == 0) cycle
        known = pack([(s, s=1, size(place))], .not. any(is_missing(amplitude_bound(:n, :, c)), dim=1))  ! without constant sensors
        if (size(known) < 2) cycle
        one%lines%points = place(known, 1, 1)
        one%lines%bends = nint(quantity(1, 1, 1)) == findloc(quantities == 'strain', .true., dim=1)
        one%lines%amplitude = transpose(amplitude(:n, known, c)*exp((0.0_dp, 1.0_dp)*phase(:n, known, c)))
        one%lines%amplitude_deviation = transpose(amplitude_bound(:n, known, c))
      end associate
    end do
  end subroutine read_result_lines

  subroutine read_block(file, name, values, problem)
    !! Read a variable of up to three dimensions, the fastest first.
    integer, intent(in) :: file
    character(*), intent(in) :: name
    real(dp), allocatable, intent(out) :: values(:, :, :)
    integer, intent(inout) :: problem            !! status of NetCDF; nothing is done after an error
    integer, parameter :: no_such_variable = -49
    type(netcdf_dimension), allocatable :: dimensions(:)
    type(netcdf_variable), allocatable :: unread(:)
    type(netcdf_variable) :: variable
    integer(i8), allocatable :: lengths(:), all(:)
    integer :: number
    number = -1
    if (problem == all_is_well) number = find_variable(file, name)
    if (problem == all_is_well .and. number < 0) problem = no_such_variable
    call read_dimensions(file, dimensions, unread, problem)
    call read_variable(file, number, variable, problem)
    if (problem /= all_is_well) return
    lengths = dimensions(variable%dimensions + 1)%length
    all = [1_i8, 1_i8, 1_i8, lengths]
    all = all(size(all):size(all) - 2:-1)
    allocate (values(all(1), all(2), all(3)))
    call read_numbers(file, number, spread(1_i8, 1, size(lengths)), lengths, values, problem)
  end subroutine read_block

end module bw_result_lines
