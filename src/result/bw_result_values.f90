module bw_result_values
  !! The values of the table's variables in a case, in SI units.
  use bw_kinds, only: dp
  use bw_beam_units, only: beam_units
  use bw_case_result, only: case_result
  use bw_double_double, only: dd, sqrt, operator(-)
  use bw_measured, only: measured_type
  use bw_missing, only: missing, is_missing
  use bw_modal_flow, only: slow_exponent, turning_square
  use bw_mode_set, only: mode_set
  use bw_response, only: response_type
  use bw_result_table, only: variable_row, variable_table
  implicit none (type, external)
  private
  public :: value_of, named_value

contains

  pure function value_of(result, row) result(values)
    !! SI values of a variable that `is_held`, (its dimension) or (1).
    type(case_result), intent(in) :: result
    type(variable_row), intent(in) :: row
    real(dp), allocatable :: values(:)
    if (result%mode_count == 0) then
      ! nothing of the case was found
      values = spread(missing, 1, merge(result%modes%count, 1, row%dimensions == 'mode'))
      return
    end if
    select case (row%dimensions)
    case ('mode')
      if (row%name == 'modal_velocity') then
        values = result%modal_velocity*result%approach_velocity
      else
        values = modal_value(result%units, result%modes, row%name)
      end if
    case ('mode_before')
      if (row%name == 'modal_velocity_before') then
        values = result%impact%modal_velocity*result%approach_velocity
      else
        values = modal_value(result%units, result%before, row%name(:index(row%name, '_before') - 1))
      end if
    case ('event'); values = event_value(result, row%name)
    case ('peak'); values = measured_value(result%measured, row%name)
    case ('point'); values = error_value(result%response, row%name)
    case default; values = impact_value(result, row%name)
    end select
  end function value_of

  pure function named_value(result, name) result(values)
    !! `value_of` by the name of the variable.
    type(case_result), intent(in) :: result
    character(*), intent(in) :: name              !! a name of the table
    real(dp), allocatable :: values(:)
    type(variable_row), allocatable :: table(:)
    table = variable_table()
    values = value_of(result, table(findloc(table%name == name, .true., dim=1)))
  end function named_value

  pure function modal_value(units, modes, name) result(values)
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:)
    select case (name)
    case ('alpha'); values = modes%alpha
    case ('wavenumber'); values = modes%alpha/units%length
    case ('angular_frequency'); values = scaled(turning_frequency(modes), units%frequency)
    case ('growth_rate'); values = growth_rate(modes)*units%frequency
    case ('modal_mass'); values = modes%modal_mass*units%mass
    case ('phase_velocity'); values = scaled(modes%phase_velocity, units%velocity)
    case default; values = scaled(modes%group_velocity, units%velocity)
    end select
  end function modal_value

  pure function impact_value(result, name) result(values)
    type(case_result), intent(in) :: result
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:)
    select case (name)
    case ('velocity_jump'); values = result%velocity_jump*result%approach_velocity
    case ('impulse'); values = [result%impact%impulse*(result%units%mass*result%approach_velocity)]
    case ('mass_velocity'); values = [result%impact%mass_velocity*result%approach_velocity]
    case ('tip_velocity'); values = [result%impact%tip_velocity*result%approach_velocity]
    case ('critical_angular_velocity'); values = [critical_speed(result, result%modes)]
    case default; values = [critical_speed(result, result%before)]
    end select
  end function impact_value

  pure real(dp) function critical_speed(result, modes) result(speed)
    !! rad/s; missing where rotation does not act in the plane of the motion.
    type(case_result), intent(in) :: result
    class(mode_set), intent(in) :: modes
    speed = missing
    if (result%can_grow) speed = modes%critical_speed%hi*result%units%frequency
  end function critical_speed

  pure function event_value(result, name) result(values)
    type(case_result), intent(in) :: result
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:)
    real(dp) :: momentum, energy
    momentum = result%units%mass*result%approach_velocity
    energy = momentum*result%approach_velocity
    associate (events => result%events)
      select case (name)
      case ('event_impulse'); values = events%impulse*momentum
      case ('energy_before'); values = events%energy_before*energy
      case ('energy_after'); values = events%energy_after*energy
      case ('momentum_before'); values = events%momentum_before*momentum
      case ('momentum_after'); values = events%momentum_after*momentum
      case ('event_time'); values = events%time
      case default; values = events%end_time
      end select
    end associate
  end function event_value

  pure function error_value(response, name) result(values)
    !! Empty where a history has no estimate.
    type(response_type), intent(in) :: response
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:)
    allocate (values(0))
    if (name == 'displacement_error' .and. allocated(response%displacement_error)) values = response%displacement_error
    if (name == 'velocity_error' .and. allocated(response%velocity_error)) values = response%velocity_error
  end function error_value

  pure function measured_value(measured, name) result(values)
    type(measured_type), intent(in) :: measured
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:)
    select case (name)
    case ('measured_angular_frequency'); values = measured%angular_frequency
    case ('measured_angular_frequency_error'); values = measured%angular_frequency_error
    case ('measured_wavenumber'); values = measured%wavenumber
    case ('measured_wavenumber_error'); values = measured%wavenumber_error
    case ('measured_phase_velocity'); values = measured%phase_velocity
    case ('measured_phase_velocity_error'); values = measured%phase_velocity_error
    case ('measured_group_velocity'); values = measured%group_velocity
    case default; values = measured%group_velocity_error
    end select
  end function measured_value

  elemental real(dp) function scaled(value, unit)
    !! What does not exist stays missing.
    real(dp), intent(in) :: value, unit
    scaled = missing
    if (.not. is_missing(value)) scaled = value*unit
  end function scaled

  pure function turning_frequency(modes) result(values)
    !! √(β² − c²/4) where it is real, 0 at the critical speed.
    class(mode_set), intent(in) :: modes
    real(dp) :: values(modes%count)
    if (allocated(modes%damping)) then
      values = frequency_of(turning_square(modes%beta_squared, modes%damping))
    else
      values = frequency_of(modes%beta_squared)
    end if
  end function turning_frequency

  pure function growth_rate(modes) result(values)
    !! The real part of the slower eigenvalue; of undamped modes |β| where β² < 0, and 0 elsewhere.
    class(mode_set), intent(in) :: modes
    real(dp) :: values(modes%count)
    type(dd) :: rate(modes%count)
    if (allocated(modes%damping)) then
      rate = slow_exponent(modes%beta_squared, modes%damping)
    else
      rate = sqrt(-modes%beta_squared)        ! 0 of a negative number
    end if
    values = rate%hi
  end function growth_rate

  elemental real(dp) function frequency_of(square) result(beta)
    type(dd), intent(in) :: square
    type(dd) :: root
    beta = missing
    if (square%hi < 0.0_dp) return
    root = sqrt(square)
    beta = root%hi
  end function frequency_of

end module bw_result_values
