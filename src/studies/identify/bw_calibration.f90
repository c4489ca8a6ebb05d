module bw_calibration
  !! Detection of sensors and hammers that are reversed or of another scale: the real factor between modal constants
  !! measured by a sensor and those of the model, by least squares.
  use bw_constants, only: gravity
  use bw_measured_state, only: amplitude_weights, measured_state, sensor_error, state_modes
  use bw_fit_search, only: misfit_chance
  use bw_kinds, only: dp
  use bw_quantile, only: normal_quantile
  use bw_record, only: sensor_type
  use bw_record_report, only: short_name
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: calibration_text

  type :: factor_type
    !! The ratio of measured to modelled modal constants of a sensor.
    integer :: sensor = 0                        !! its number
    real(dp) :: value = 0.0_dp, deviation = huge(1.0_dp)
    real(dp) :: weight = 0.0_dp         !! of the value
  end type factor_type

contains

  subroutine find_factors(states, values, factors)
    !! Find the factors of all sensors: the mean over repeats, which share the errors of model and positions.
    type(measured_state), intent(inout) :: states(:) !! one or more repeats with modal constants, and their assignments
    real(dp), intent(in) :: values(:)            !! of the unknowns
    type(factor_type), allocatable, intent(out) :: factors(:)
    type(state_modes) :: modes
    real(dp) :: factor(size(states(1)%lines%sensor)), error(size(states(1)%lines%sensor))
    integer, allocatable :: line(:)
    integer :: i, k
    allocate (factors(size(states(1)%lines%sensor)))
    factors%sensor = states(1)%lines%sensor
    do i = 1, size(states)
      associate (lines => states(i)%lines)
        if (size(lines%sensor) /= size(factors)) cycle
        if (any(lines%sensor /= factors%sensor)) cycle
        line = pack([(k, k=1, size(states(i)%mode_of))], states(i)%mode_of > 0)
        call states(i)%modes_at(values, states(i)%mode_of(line), modes)
        if (.not. modes%found .or. size(line) == 0) cycle
        call best_factors(lines%amplitude(:, line), lines%amplitude_deviation(:, line), modes%shape, factor, error)
        factors%value = factors%value + factor/error**2
        factors%weight = factors%weight + 1/error**2
        factors%deviation = min(factors%deviation, error)
      end associate
    end do
    if (any(.not. factors%weight > 0)) deallocate (factors)
    if (.not. allocated(factors)) allocate (factors(0))
    factors%value = factors%value/factors%weight
  end subroutine find_factors

  pure subroutine best_factors(amplitude, deviation, shape, factor, error)
    !! Fit one factor per sensor to all lines; its standard deviation grows if the shapes fit worse than expected.
    complex(dp), intent(in) :: amplitude(:, :)   !! modal constants, (sensors, lines)
    real(dp), intent(in) :: deviation(:, :)      !! of real and imaginary part, > 0, (sensors, lines)
    real(dp), intent(in) :: shape(:, :)          !! the model's modal constants, (lines, sensors)
    real(dp), intent(out) :: factor(:), error(:) !! (sensors)
    real(dp) :: weight(size(amplitude, 1), size(amplitude, 2)), known, misfit
    integer :: k, s
    do k = 1, size(amplitude, 2)
      weight(:, k) = amplitude_weights(amplitude(:, k), deviation(:, k), sensor_error)
    end do
    do s = 1, size(factor)
      known = max(sum(weight(s, :)*shape(:, s)**2), tiny(1.0_dp))
      factor(s) = sum(weight(s, :)*shape(:, s)*amplitude(s, :)%re)/known
      misfit = sum(weight(s, :)*abs(amplitude(s, :) - factor(s)*shape(:, s))**2)/max(1, 2*size(amplitude, 2) - 1)
      error(s) = sqrt(max(1.0_dp, misfit)/known)
    end do
  end subroutine best_factors

  pure elemental logical function differs(factor, from)
    !! Return whether a factor differs from a number by more than its error and that of calibration.
    type(factor_type), intent(in) :: factor
    real(dp), intent(in) :: from
    differs = abs(factor%value - from) > normal_quantile(1 - misfit_chance/2)*hypot(factor%deviation, sensor_error*from)
  end function differs

  function calibration_text(states, values, sensors, explained) result(text)
    !! Name sensors that seem to be reversed or, if the model explains the lines, of another scale; empty if there are none,
    !! or not all states have modal constants.
    type(measured_state), intent(inout) :: states(:) !! see `find_factors`
    real(dp), intent(in) :: values(:)
    type(sensor_type), allocatable, intent(in) :: sensors(:)   !! unallocated: no modal constants
    logical, intent(in) :: explained
    character(:), allocatable :: text
    type(factor_type), allocatable :: factors(:)
    real(dp) :: common
    integer :: i
    text = ''
    if (size(states) == 0 .or. .not. all([(states(i)%lines%over_blow, i=1, size(states))])) return
    call find_factors(states, values, factors)
    if (size(factors) == 0) return
    common = sum(factors%value/factors%deviation**2)/sum(1/factors%deviation**2)
    if (all(differs(factors, 1.0_dp)) .and. .not. any(differs(factors, common))) then
      text = fault_text('the force or all sensors seem to be', common, all([(sensors(factors(i)%sensor)%quantity == &
        'acceleration', i=1, size(factors))]), .not. any(differs(factors, -1.0_dp)), explained)
    else
      do i = 1, size(factors)
        if (.not. (differs(factors(i), 1.0_dp) .and. differs(factors(i), 0.0_dp))) cycle
        associate (sensor => sensors(factors(i)%sensor))
          text = text//fault_text('sensor '//short_name(sensor%name)//' seems to be', factors(i)%value, &
                                  sensor%quantity == 'acceleration', .not. differs(factors(i), -1.0_dp), explained)
        end associate
      end do
    end if
    if (text /= '') text = 'calibration: '//text(3:)
  end function calibration_text

  pure function fault_text(what, factor, accelerates, only_reversed, explained) result(text)
    !! Describe the fault after a semicolon, and the factor that corrects it; empty if uncertain.
    character(*), intent(in) :: what             !! seems to be …
    real(dp), intent(in) :: factor               !! measured over modelled modal constants
    logical, intent(in) :: accelerates           !! an acceleration is measured
    logical, intent(in) :: only_reversed, explained
    character(:), allocatable :: text
    real(dp), parameter :: near = 0.05_dp
    text = ''
    if (factor < 0 .and. (only_reversed .or. explained)) text = '; '//what//' reversed'
    if (only_reversed) then
      text = text//': with factor -1 (record%scale) the modal constants are those of the model'
    else if (explained) then
      if (text == '') text = '; '//what//' of another scale'
      text = text//': with factor '//shortest(1/factor, 2)//' (record%scale) the modal constants are those of the model'
      if (accelerates .and. abs(abs(factor)*gravity - 1) < near) text = text//', as of accelerations in g taken for m/s2'
    end if
  end function fault_text

end module bw_calibration
