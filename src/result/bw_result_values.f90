module bw_result_values
  !! The values of the table's variables in a case, in SI units.
  !!
  !! A sweep asks for them case by case: which value a row names is found out once (`key_of`), and values go straight
  !! to where they are kept.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result
  use bw_event, only: event_type
  use bw_measured, only: measured_type
  use bw_missing, only: missing, scaled
  use bw_modal_values, only: modal_names, put_modal
  use bw_mode_set, only: mode_set
  use bw_response, only: response_type
  use bw_result_table, only: variable_row, variable_table
  implicit none (type, external)
  private
  public :: key_of, put_value, named_value

  enum, bind(c)
    !! Whose values they are.
    enumerator :: of_modes = 1, of_modes_before, of_events, of_peaks, of_errors, of_impact
  end enum

  type, public :: value_key
    !! Which value of a case a row of the table names.
    private
    integer :: source = 0
    integer :: what = 0          !! place among the names of its source
  end type value_key

  character(*), parameter :: event_names(*) = [character(16) :: 'event_impulse', 'energy_before', 'energy_after', &
    'momentum_before', 'momentum_after', 'event_time', 'event_end', 'event_time_error', 'event_end_error']
  character(*), parameter :: measured_names(*) = [character(32) :: 'measured_angular_frequency', &
    'measured_angular_frequency_error', 'measured_wavenumber', 'measured_wavenumber_error', 'measured_phase_velocity', &
    'measured_phase_velocity_error', 'measured_group_velocity', 'measured_group_velocity_error']
  character(*), parameter :: error_names(*) = [character(18) :: 'displacement_error', 'velocity_error']
  character(*), parameter :: impact_names(*) = [character(32) :: 'velocity_jump', 'impulse', 'mass_velocity', &
    'tip_velocity', 'critical_angular_velocity', 'critical_angular_velocity_before']
  character(*), parameter :: before = '_before'

contains

  pure type(value_key) function key_of(row) result(key)
    !! Where to look for a variable that `is_held`.
    type(variable_row), intent(in) :: row
    select case (row%dimensions)
    case ('mode'); key = value_key(of_modes, place(modal_names, row%name))
    case ('mode_before'); key = value_key(of_modes_before, place(modal_names, row%name(:index(row%name, before) - 1)))
    case ('event'); key = value_key(of_events, place(event_names, row%name))
    case ('peak'); key = value_key(of_peaks, place(measured_names, row%name))
    case ('point'); key = value_key(of_errors, place(error_names, row%name))
    case default; key = value_key(of_impact, place(impact_names, row%name))
    end select
  end function key_of

  pure integer function place(names, name)
    character(*), intent(in) :: names(:), name
    place = findloc(names == name, .true., dim=1)
  end function place

  pure subroutine put_value(result, key, values)
    !! SI values of a variable; fill behind them, and of all of a case of which nothing was found.
    type(case_result), intent(in) :: result
    type(value_key), intent(in) :: key
    real(dp), intent(out), contiguous :: values(:)     !! its dimension, or 1
    integer :: n
    n = 0
    if (result%mode_count > 0) then
      n = min(value_count(result, key), size(values))
      select case (key%source)
      case (of_modes); call put_modal(result, result%modes, result%modal_velocity, key%what, values(:n))
      case (of_modes_before); call put_modal(result, result%before, result%impact%modal_velocity, key%what, values(:n))
      case (of_events); call put_event(result, result%events(:n), key%what, values(:n))
      case (of_peaks); call put_measured(result%measured, key%what, values(:n))
      case (of_errors); call put_error(result%response, key%what, values(:n))
      case default; call put_impact(result, key%what, values(:n))
      end select
    end if
    values(n + 1:) = missing
  end subroutine put_value

  pure integer function value_count(result, key) result(n)
    !! How many values a case has; none where a history has no estimate.
    type(case_result), intent(in) :: result
    type(value_key), intent(in) :: key
    n = 1
    select case (key%source)
    case (of_modes); n = result%modes%count
    case (of_modes_before); n = result%before%count
    case (of_events); n = size(result%events)
    case (of_peaks); n = size(result%measured%angular_frequency)
    case (of_errors)
      n = 0
      if (key%what == 1 .and. allocated(result%response%displacement_error)) n = size(result%response%displacement_error)
      if (key%what == 2 .and. allocated(result%response%velocity_error)) n = size(result%response%velocity_error)
    case default
      if (key%what == 1) n = size(result%velocity_jump)
    end select
  end function value_count

  pure function named_value(result, name) result(values)
    !! SI values of a variable by its name, (its dimension) or (1).
    type(case_result), intent(in) :: result
    character(*), intent(in) :: name              !! a name of the table, held by the scene's result
    real(dp), allocatable :: values(:)
    type(variable_row), allocatable :: table(:)
    type(value_key) :: key
    integer :: n
    table = variable_table()
    key = key_of(table(findloc(table%name == name, .true., dim=1)))
    n = merge(result%modes%count, 1, key%source == of_modes)
    if (result%mode_count > 0) n = value_count(result, key)
    allocate (values(n))
    call put_value(result, key, values)
  end function named_value

  pure subroutine put_impact(result, what, values)
    type(case_result), intent(in) :: result
    integer, intent(in) :: what
    real(dp), intent(out), contiguous :: values(:)
    associate (speed => result%approach_velocity)
      select case (what)          ! by places in impact_names
      case (1); values = result%velocity_jump(:size(values))*speed
      case (2); values = result%impact%impulse*(result%units%mass*speed)
      case (3); values = result%impact%mass_velocity*speed
      case (4); values = result%impact%tip_velocity*speed
      case (5); values = critical_speed(result, result%modes)
      case default; values = critical_speed(result, result%before)
      end select
    end associate
  end subroutine put_impact

  pure real(dp) function critical_speed(result, modes) result(speed)
    !! rad/s; missing where no speed makes a mode grow.
    type(case_result), intent(in) :: result
    class(mode_set), intent(in) :: modes
    speed = missing
    if (result%can_grow .and. modes%critical_speed%hi > 0.0_dp) speed = modes%critical_speed%hi*result%units%frequency
  end function critical_speed

  pure subroutine put_event(result, events, what, values)
    type(case_result), intent(in) :: result
    type(event_type), intent(in) :: events(:)
    integer, intent(in) :: what
    real(dp), intent(out), contiguous :: values(:)
    real(dp) :: momentum, energy
    momentum = result%units%mass*result%approach_velocity
    energy = momentum*result%approach_velocity
    select case (what)          ! by places in event_names
    case (1); values = scaled(events%impulse, momentum)
    case (2); values = scaled(events%energy_before, energy)
    case (3); values = scaled(events%energy_after, energy)
    case (4); values = scaled(events%momentum_before, momentum)
    case (5); values = scaled(events%momentum_after, momentum)
    case (6); values = events%time
    case (7); values = events%end_time
    case (8); values = events%time_error
    case default; values = events%end_error
    end select
  end subroutine put_event

  pure subroutine put_error(response, what, values)
    type(response_type), intent(in) :: response
    integer, intent(in) :: what
    real(dp), intent(out), contiguous :: values(:)
    if (size(values) == 0) return
    if (what == 1) then           ! by places in error_names
      values = response%displacement_error(:size(values))
    else
      values = response%velocity_error(:size(values))
    end if
  end subroutine put_error

  pure subroutine put_measured(measured, what, values)
    type(measured_type), intent(in) :: measured
    integer, intent(in) :: what
    real(dp), intent(out), contiguous :: values(:)
    integer :: n
    n = size(values)
    select case (what)          ! by places in measured_names
    case (1); values = measured%angular_frequency(:n)
    case (2); values = measured%angular_frequency_error(:n)
    case (3); values = measured%wavenumber(:n)
    case (4); values = measured%wavenumber_error(:n)
    case (5); values = measured%phase_velocity(:n)
    case (6); values = measured%phase_velocity_error(:n)
    case (7); values = measured%group_velocity(:n)
    case default; values = measured%group_velocity_error(:n)
    end select
  end subroutine put_measured

end module bw_result_values
