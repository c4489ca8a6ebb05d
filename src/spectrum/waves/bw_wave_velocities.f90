module bw_wave_velocities
  !! Wave numbers and velocities in SI from the α of each line: phase velocities line by line, group velocities, √(EI/ρA) and ω
  !! from the dispersion of all lines.
  use bw_dispersion, only: dispersion_type, fit_dispersion, group_velocity_of
  use bw_kinds, only: dp
  use bw_note, only: remark
  use bw_quantile, only: normal, squares_deviation, student_quantile
  use bw_sensor_lines, only: measured_lines, sensor_facts, sensor_waves, square_of
  use bw_shape_fit, only: rounding
  use bw_text, only: append
  implicit none (type, external)
  private
  public :: fill_dispersion, fill_waves

  real(dp), parameter, public :: unlikely = 3.0902_dp  !! a normal number exceeds it with a probability of 1/1000

  type, public :: wave_type
    !! The wave number of a line times the beam's length.
    real(dp) :: alpha = 1, error = 0
    real(dp) :: deviation = 0                  !! standard deviation of a normal number with that error
    logical :: exists = .false.
  end type wave_type

contains

  pure subroutine fill_waves(facts, lines, found, waves)
    !! Fill in wave numbers, and phase velocities of the undamped lines.
    type(sensor_facts), intent(in) :: facts
    type(measured_lines), intent(in) :: lines
    type(wave_type), intent(in) :: found(:)
    type(sensor_waves), intent(inout) :: waves
    where (found%exists)
      waves%wavenumber = found%alpha/facts%length
      waves%wavenumber_error = found%error/facts%length
      waves%phase_velocity = sqrt(square_of(lines))/waves%wavenumber
      waves%phase_velocity_error = waves%phase_velocity*(hypot(found%error/found%alpha, &
        & student_quantile(facts%confidence, normal)*lines%frequency_deviation/lines%angular_frequency) + rounding)
    end where
  end subroutine fill_waves

  pure subroutine fill_dispersion(facts, lines, found, on_curve, waves, agree)
    !! Fill in √(EI/ρA), ω and group velocities from the lines that lie on one curve.
    type(sensor_facts), intent(in) :: facts
    type(measured_lines), intent(in) :: lines
    type(wave_type), intent(in) :: found(:)
    logical, intent(in) :: on_curve(:)         !! (line)
    type(sensor_waves), intent(inout) :: waves
    logical, intent(out) :: agree(:)           !! lines that overdetermine a curve, if all fit it
    type(dispersion_type) :: curve
    real(dp), dimension(size(found)) :: square, variance, velocity, deviation
    real(dp) :: quantile, reach, unit
    integer :: power
    agree = .false.
    if (.not. any(on_curve)) return
    power = exponent(maxval(square_of(lines)))
    unit = scale(1.0_dp, (power - modulo(power, 2))/2)   ! of frequency: results have the same bits in other units of time
    square = square_of(lines)/unit/unit
    variance = found%deviation**2 + (found%alpha*lines%frequency_deviation/(2*lines%angular_frequency))**2
    curve = fit_dispersion(pack(square, on_curve), pack(found%alpha, on_curve), pack(variance, on_curve), facts%rotates)
    if (.not. curve%exists) then
      call remark(waves%notes, 'group velocities are missing, since '// &
        & 'the wave numbers do not determine the dispersion; a rotating beam needs two')
      return
    end if
    if (any(found%exists .and. .not. on_curve)) call remark(waves%notes, 'lines off the dispersion '// &
      & 'curve of the others have no group velocity')
    quantile = student_quantile(facts%confidence, normal)
    if (curve%freedom > 0) then
      agree = on_curve
      if (squares_deviation(curve%misfit, curve%freedom) > unlikely) then
        call append(waves%notes, 'the wave numbers differ by more than their errors from the dispersion of '// &
          & 'a uniform beam; intervals of group velocities are widened')
        agree = .false.
        quantile = student_quantile(facts%confidence, curve%freedom)
        curve%covariance = curve%covariance*curve%misfit/curve%freedom
      end if
    end if
    call group_velocity_of(curve, square, 2*(lines%angular_frequency/unit)*(lines%frequency_deviation/unit), velocity, deviation)
    where (on_curve)
      waves%group_velocity = velocity*facts%length*unit
      waves%group_velocity_error = (quantile*deviation + 2*rounding*velocity)*facts%length*unit
    end where
    waves%stiffness_root = facts%length**2*unit/curve%q**2
    waves%stiffness_root_error = waves%stiffness_root*quantile*2*sqrt(curve%covariance(1, 1))/curve%q
    if (.not. facts%rotates) return
    reach = quantile*sqrt(curve%covariance(2, 2))
    waves%angular_velocity = unit*sqrt(max(curve%turning, 0.0_dp))
    waves%angular_velocity_error = max(unit*sqrt(max(curve%turning + reach, 0.0_dp)) - waves%angular_velocity, &
      & waves%angular_velocity - unit*sqrt(max(curve%turning - reach, 0.0_dp)))
  end subroutine fill_dispersion

end module bw_wave_velocities
