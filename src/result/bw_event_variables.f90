module bw_event_variables
  !! What a result holds of the impact and of every event: its rows, and behind them the procedures that give their values,
  !! which are named after them. What a procedure gives is said in its row. A case itself has its masses in m_i and its
  !! velocities in the approach velocity V.
  use bw_beam_units, only: in_joules, in_newton_seconds
  use bw_case_result, only: case_result
  use bw_event, only: event_words
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_mode_set, only: mode_set
  use bw_netcdf, only: variable_text
  use bw_result_variable, only: case_variable, result_variable
  use bw_text, only: joined
  implicit none (type, external)
  private
  public :: impact_variables, event_variables, event_kinds

  character(*), parameter :: momentum_words = &
    'generalised momentum of the first mode that the mass strikes, per unit of displacement there'

contains

  pure function impact_variables() result(rows)
    !! Of the state just after the impact, and of the angular velocities above which beam and mass are unstable.
    type(result_variable) :: rows(6)
    rows = [ &
      case_variable(variable_text('velocity_jump', 'profile', 'm s-1', 'jump of the velocity along the beam at the impact', &
                                  'Fig. 3'), velocity_jump, needs='event'), &
      case_variable(variable_text('impulse', '', 'N s', 'impulse of the impact on the beam', &
                                  'Eq. 12, reference [8]'), impulse, needs='event'), &
      case_variable(variable_text('mass_velocity', '', 'm s-1', 'velocity of the mass just after the impact', &
                                  'Eq. 12, reference [8]'), mass_velocity, needs='event'), &
      case_variable(variable_text('tip_velocity', '', 'm s-1', &
                                  'velocity of the beam where the mass strikes, just after the impact', &
                                  'Eq. 12, reference [8]'), tip_velocity, needs='event'), &
      case_variable(variable_text('critical_angular_velocity', '', 'rad s-1', &
                                  'lowest angular velocity at which a mode is unstable', 'Eq. 31'), critical, needs='mode'), &
      case_variable(variable_text('critical_angular_velocity_before', '', 'rad s-1', &
                                  'lowest angular velocity at which a mode is unstable, before the capture', 'Eq. 31'), &
                    critical_before, needs='mode_before')]
  end function impact_variables

  pure function event_variables() result(rows)
    !! Of every event, in the order of time.
    type(result_variable) :: rows(9)
    rows = [ &
      case_variable(variable_text('event_time', 'event', 's', 'time of the event'), event_time), &
      case_variable(variable_text('event_end', 'event', 's', 'end of the event'), event_end), &
      case_variable(variable_text('event_time_error', 'event', 's', 'estimate of the error of the time of the event'), &
                    event_time_error, needs='contacts'), &
      case_variable(variable_text('event_end_error', 'event', 's', 'estimate of the error of the end of the event'), &
                    event_end_error, needs='contacts'), &
      case_variable(variable_text('event_impulse', 'event', 'N s', 'impulse of the event on the beam'), event_impulse), &
      case_variable(variable_text('energy_before', 'event', 'J', 'energy of beam and mass before the event'), energy_before), &
      case_variable(variable_text('energy_after', 'event', 'J', 'energy of beam and mass after the event'), energy_after), &
      case_variable(variable_text('momentum_before', 'event', 'kg m s-1', &
                                  momentum_words//', before the event'), &
                    momentum_before), &
      case_variable(variable_text('momentum_after', 'event', 'kg m s-1', &
                                  momentum_words//', after the event'), &
                    momentum_after)]
  end function event_variables

  pure function event_kinds() result(rows)
    !! What kind of event each is: 0 behind the last.
    type(result_variable) :: rows(1)
    rows = [case_variable(variable_text('event_kind', 'event', '1', 'kind of the event', is_integer=.true., &
                                        flags=joined(event_words)), event_kind)]
  end function event_kinds

  pure subroutine velocity_jump(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%velocity_jump(:size(values))*result%approach_velocity
  end subroutine velocity_jump

  pure subroutine impulse(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = in_newton_seconds(result%impact%impulse, result%units, result%approach_velocity)
  end subroutine impulse

  pure subroutine mass_velocity(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%impact%mass_velocity*result%approach_velocity
  end subroutine mass_velocity

  pure subroutine tip_velocity(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%impact%tip_velocity*result%approach_velocity
  end subroutine tip_velocity

  pure subroutine critical(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = critical_speed(result, result%modes)
  end subroutine critical

  pure subroutine critical_before(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = critical_speed(result, result%before)
  end subroutine critical_before

  pure real(dp) function critical_speed(result, modes) result(speed)
    !! rad/s; missing where no angular velocity makes a mode grow.
    type(case_result), intent(in) :: result
    class(mode_set), intent(in) :: modes
    speed = missing
    if (result%can_grow .and. modes%critical_speed%hi > 0.0_dp) speed = modes%critical_speed%hi*result%units%frequency
    if (result%can_grow .and. modes%grows_at_any_speed) speed = 0.0_dp
  end function critical_speed

  pure subroutine event_time(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%events(:size(values))%time
  end subroutine event_time

  pure subroutine event_end(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%events(:size(values))%end_time
  end subroutine event_end

  pure subroutine event_time_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%events(:size(values))%time_error
  end subroutine event_time_error

  pure subroutine event_end_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%events(:size(values))%end_error
  end subroutine event_end_error

  pure subroutine event_kind(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%events(:size(values))%kind
  end subroutine event_kind

  pure subroutine event_impulse(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = in_newton_seconds(result%events(:size(values))%impulse, result%units, result%approach_velocity)
  end subroutine event_impulse

  pure subroutine energy_before(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = in_joules(result%events(:size(values))%energy_before, result%units, result%approach_velocity)
  end subroutine energy_before

  pure subroutine energy_after(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = in_joules(result%events(:size(values))%energy_after, result%units, result%approach_velocity)
  end subroutine energy_after

  pure subroutine momentum_before(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = in_newton_seconds(result%events(:size(values))%momentum_before, result%units, result%approach_velocity)
  end subroutine momentum_before

  pure subroutine momentum_after(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = in_newton_seconds(result%events(:size(values))%momentum_after, result%units, result%approach_velocity)
  end subroutine momentum_after

end module bw_event_variables
