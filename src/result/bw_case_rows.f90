module bw_case_rows
  !! The variables of a case in a result: a row for each, with values in SI. A case itself has masses in units of m_i
  !! and velocities in units of the approach velocity V.
  use bw_beam_units, only: beam_units, in_joules, in_newton_seconds
  use bw_case_result, only: case_result, contact_result, load_result
  use bw_event, only: event_type, event_words
  use bw_history_rows, only: estimate_of, history_rows, largest_of, spectrum_rows
  use bw_kinds, only: dp
  use bw_missing, only: missing, scaled
  use bw_modal_flow, only: find_angular_frequencies, find_growth_rates
  use bw_mode_set, only: mode_set
  use bw_model_rows, only: model_rows
  use bw_record_rows, only: record_rows
  use bw_result_table, only: result_table
  implicit none (type, external)
  private
  public :: all_modes, case_rows, starts_of, values_of

  character(*), parameter :: of_blow = 'Eq. 12, reference [8]', &
    momentum = 'generalised momentum of the first mode that the mass strikes, per unit of displacement there'

  type :: modal_row
    character(17) :: name
    character(7) :: units
    character(44) :: long_name
  end type modal_row

  type(modal_row), parameter :: of_modes(*) = [ &
    modal_row('alpha', '1', 'wave number times length'), &
    modal_row('wavenumber', 'm-1', 'wave number P'), &
    modal_row('angular_frequency', 'rad s-1', 'angular frequency'), &
    modal_row('growth_rate', 's-1', 'growth rate, the real part of the eigenvalue'), &
    modal_row('modal_mass', 'kg', 'modal mass'), &
    modal_row('phase_velocity', 'm s-1', 'phase velocity'), &
    modal_row('group_velocity', 'm s-1', 'group velocity')]     !! variables of each mode set

contains

  subroutine case_rows(table, result)
    !! Walk through all rows that depend on the case.
    class(result_table), intent(inout) :: table
    type(case_result), intent(in), target :: result    !! empty while rows are defined
    class(mode_set), pointer :: modes, before
    modes => null()
    before => null()
    if (allocated(result%modes)) modes => result%modes
    if (allocated(result%before)) before => result%before
    call modal_rows(table, result%units, modes, 'mode', &
                    [character(12) :: 'Eq. 19', 'Eq. 19', 'Eq. 30', 'Eq. 27', 'Eq. 21', 'Eq. 32', 'Eq. 33'])
    call table%begin_names('_before', ', before the capture')
    call modal_rows(table, result%units, before, 'mode_before', &
                    [character(12) :: 'Eq. 8', 'Eq. 8', 'Eqs 2 and 10', 'Eqs 2 and 10', 'Eq. 10', 'Eq. 32', 'Eq. 33'])
    call table%begin_names('', '')
    if (table%real_row('modal_velocity', 'mode', 'm s-1', 'modal velocity just after the last event at t = 0', 'Eq. 26', &
                       needs='blow')) &
      call table%put(result%modal_velocity(:modes%count)*result%approach_velocity)
    if (table%real_row('modal_velocity_before', 'mode_before', 'm s-1', 'jump of the modal velocity at the impact', 'Eq. 12', &
                       needs='blow')) &
      call table%put(result%impact%modal_velocity(:before%count)*result%approach_velocity)
    if (table%real_row('mode_shape', 'mode profile', '1', 'mode shape', 'Eq. 18', needs='mode_shapes')) &
      call table%put_columns(shapes_of(modes, result%profile_points))
    if (table%layout%modal_model) call model_rows(table, result%model)
    call configuration_rows(table, result)
    call impact_rows(table, result, modes, before)
    call event_rows(table, result%events, result%units, result%approach_velocity, result%lever)
    call contact_rows(table, result%contact)
    call load_rows(table, result%loads)
    call history_rows(table, result%response)
    call spectrum_rows(table, result%amplitude, result%answer, result%measured)
    if (table%layout%of_record) call record_rows(table, result%record)
    if (table%whole_row('mode_count', '', 'number of modes', needs='mode')) call table%put([result%mode_count])
    if (table%whole_row('note_count', '', 'number of notes', needs='case')) call table%put([size(result%notes)])
  end subroutine case_rows

  subroutine modal_rows(table, units, modes, dimension, equations)
    !! Walk through the rows of any mode set.
    class(result_table), intent(inout) :: table
    type(beam_units), intent(in) :: units
    class(mode_set), pointer, intent(in) :: modes
    character(*), intent(in) :: dimension
    character(*), intent(in) :: equations(:)           !! of the paper, for each of `of_modes`
    integer :: i
    do i = 1, size(of_modes)
      if (table%real_row(trim(of_modes(i)%name), dimension, trim(of_modes(i)%units), trim(of_modes(i)%long_name), equations(i), &
                         summary=dimension == 'mode' .and. of_modes(i)%name == 'angular_frequency')) &
        call table%put(modal_values(modes, units, of_modes(i)%name))
    end do
  end subroutine modal_rows

  subroutine configuration_rows(table, result)
    !! Put the modes of all configurations of a beam that changes in time, and their first beginnings.
    class(result_table), intent(inout) :: table
    type(case_result), intent(in) :: result
    integer :: i
    if (table%real_row('configuration_start', 'configuration', 's', 'time at which the configuration begins first')) &
      call table%put(starts_of(result))
    do i = 1, size(of_modes)
      if (table%real_row('configuration_'//trim(of_modes(i)%name), 'configuration mode', trim(of_modes(i)%units), &
                         trim(of_modes(i)%long_name)//', of every configuration')) &
        call table%put_columns(all_modes(result, of_modes(i)%name))
    end do
  end subroutine configuration_rows

  function starts_of(result) result(seconds)
    !! Return when each configuration begins; missing if not before the end of the record.
    type(case_result), intent(in) :: result
    real(dp), allocatable :: seconds(:)
    integer :: c, i
    allocate (seconds(size(result%configurations)), source=missing)
    do i = size(result%segments), 1, -1
      c = result%segments(i)%configuration
      seconds(c) = result%segments(i)%start%hi*result%units%time%hi
    end do
  end function starts_of

  function all_modes(result, name) result(values)
    !! Return values of every configuration, (modes, configurations).
    type(case_result), intent(in) :: result
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:, :)
    integer :: c, n
    n = 0
    do c = 1, size(result%configurations)
      if (allocated(result%configurations(c)%set)) n = max(n, result%configurations(c)%set%count)
    end do
    allocate (values(n, size(result%configurations)), source=missing)
    do c = 1, size(result%configurations)
      if (.not. allocated(result%configurations(c)%set)) cycle
      values(:result%configurations(c)%set%count, c) = modal_values(result%configurations(c)%set, result%units, name)
    end do
  end function all_modes

  pure function modal_values(modes, units, name) result(values)
    !! Return one of `of_modes` in SI; missing for modes that lack it.
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    character(*), intent(in) :: name
    real(dp) :: values(modes%count)
    select case (name)
    case ('alpha')
      values = modes%alpha(:modes%count)
    case ('wavenumber')
      values = modes%alpha(:modes%count)/units%length
    case ('angular_frequency')
      call find_angular_frequencies(modes, values)
      values = scaled(values, units%frequency)
    case ('growth_rate')
      call find_growth_rates(modes, values)
      values = values*units%frequency
    case ('modal_mass')
      values = modes%modal_mass(:modes%count)*units%mass
    case ('phase_velocity')
      values = scaled(modes%phase_velocity(:modes%count), units%velocity)
    case default
      values = scaled(modes%group_velocity(:modes%count), units%velocity)
    end select
  end function modal_values

  function shapes_of(modes, points) result(shapes)
    !! Return mode shapes at evenly spaced places, (places, modes).
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: points
    real(dp), allocatable :: shapes(:, :)
    integer :: j
    shapes = transpose(modes%some_shapes(1, modes%count, [(real(j, dp)/(points - 1), j=0, points - 1)]))
  end function shapes_of

  subroutine impact_rows(table, result, modes, before)
    !! Put the state just after the impact, and the critical angular velocities of beam and mass.
    class(result_table), intent(inout) :: table
    type(case_result), intent(in) :: result
    class(mode_set), pointer, intent(in) :: modes, before
    associate (velocity => result%approach_velocity)
      if (table%real_row('velocity_jump', 'profile', 'm s-1', 'jump of the velocity along the beam at the impact', 'Fig. 3', &
                         needs='blow')) call table%put(result%velocity_jump*velocity)
      if (table%real_row('impulse', '', 'N s', 'impulse of the impact on the beam', of_blow, needs='blow', &
                         summary=.true.)) &
        call table%put([in_newton_seconds(result%impact%impulse, result%units, velocity)])
      if (table%real_row('mass_velocity', '', 'm s-1', 'velocity of the mass just after the impact', of_blow, needs='blow')) &
        call table%put([result%impact%mass_velocity*velocity])
      if (table%real_row('tip_velocity', '', 'm s-1', 'velocity of the beam where the mass strikes, just after the impact', &
                         of_blow, needs='blow')) call table%put([result%impact%tip_velocity*velocity])
    end associate
    if (table%real_row('critical_angular_velocity', '', 'rad s-1', 'lowest angular velocity at which a mode is unstable', &
                       'Eq. 31', needs='mode', summary=.true.)) call table%put([critical_speed(result, modes)])
    if (table%real_row('critical_angular_velocity_before', '', 'rad s-1', &
                       'lowest angular velocity at which a mode is unstable, before the capture', 'Eq. 31', &
                       needs='mode_before')) call table%put([critical_speed(result, before)])
  end subroutine impact_rows

  pure real(dp) function critical_speed(result, modes) result(speed)
    !! Return the critical angular velocity, rad/s; missing if no speed makes a mode unstable.
    type(case_result), intent(in) :: result
    class(mode_set), intent(in) :: modes
    speed = missing
    if (result%can_grow .and. modes%critical_speed%hi > 0.0_dp) speed = modes%critical_speed%hi*result%units%frequency
    if (result%can_grow .and. modes%grows_at_any_speed) speed = 0.0_dp
  end function critical_speed

  subroutine event_rows(table, events, units, velocity, lever)
    !! Put all events in the order of time; their kind is 0 after the last.
    class(result_table), intent(inout) :: table
    type(event_type), intent(in), optional :: events(:)
    type(beam_units), intent(in) :: units
    real(dp), intent(in) :: velocity                   !! of approach
    real(dp), intent(in) :: lever                      !! distance of the struck point from the axis of a free hub, m
    character(*), parameter :: angular = 'angular momentum about the axis, less that of the even rotation'
    if (table%real_row('event_time', 'event', 's', 'time of the event')) call table%put(events%time)
    if (table%real_row('event_end', 'event', 's', 'end of the event')) call table%put(events%end_time)
    if (table%real_row('event_time_error', 'event', 's', 'estimate of the error of the time of the event', &
                       needs='contacts')) call table%put(events%time_error)
    if (table%real_row('event_end_error', 'event', 's', 'estimate of the error of the end of the event', &
                       needs='contacts')) call table%put(events%end_error)
    if (table%real_row('event_impulse', 'event', 'N s', 'impulse of the event on the beam')) &
      call table%put(in_newton_seconds(events%impulse, units, velocity))
    if (table%real_row('energy_before', 'event', 'J', 'energy of beam and mass before the event')) &
      call table%put(in_joules(events%energy_before, units, velocity))
    if (table%real_row('energy_after', 'event', 'J', 'energy of beam and mass after the event')) &
      call table%put(in_joules(events%energy_after, units, velocity))
    if (table%real_row('momentum_before', 'event', 'kg m s-1', momentum//', before the event')) &
      call table%put(in_newton_seconds(events%momentum_before, units, velocity))
    if (table%real_row('momentum_after', 'event', 'kg m s-1', momentum//', after the event')) &
      call table%put(in_newton_seconds(events%momentum_after, units, velocity))
    if (table%real_row('angular_momentum_before', 'event', 'kg m2 s-1', angular//', before the event', needs='hub')) &
      call table%put(scaled(in_newton_seconds(events%momentum_before, units, velocity), lever))
    if (table%real_row('angular_momentum_after', 'event', 'kg m2 s-1', angular//', after the event', needs='hub')) &
      call table%put(scaled(in_newton_seconds(events%momentum_after, units, velocity), lever))
    if (table%real_row('hub_rate_change', 'event', 'rad s-1', 'change of the mean angular velocity of the hub', needs='hub')) &
      call table%put(scaled(events%hub_rate_change, velocity/units%length))
    if (table%whole_row('event_kind', 'event', 'kind of the event', event_words)) call table%put(events%kind)
  end subroutine event_rows

  subroutine contact_rows(table, contact)
    !! Put the force of lasting contacts, and the rebound of the mass.
    class(result_table), intent(inout) :: table
    type(contact_result), intent(in), optional :: contact
    if (table%real_row('restitution', '', '1', 'velocity at which mass and beam separate after the first contact over that at '// &
                       'which they met', needs='contact_sample', summary=.true.)) call table%put([contact%restitution])
    if (table%real_row('final_mass_velocity', '', 'm s-1', 'velocity of the mass after its last contact', &
                       needs='contact_sample', summary=.true.)) call table%put([contact%leaving])
    if (table%real_row('largest_indentation', '', 'm', 'largest indentation of all contacts', needs='contact_sample', &
                       summary=.true.)) call table%put([contact%indentation])
    if (table%real_row('largest_contact_force', '', 'N', 'largest contact force of all contacts', needs='contact_sample', &
                       summary=.true.)) &
      call table%put(largest_of(reshape(contact%largest, [size(contact%largest), 1])))
    if (table%real_row('event_force', 'event', 'N', 'largest contact force of the event', needs='contact_sample')) &
      call table%put(contact%largest)
    if (table%real_row('event_force_time', 'event', 's', 'time of the largest contact force of the event', &
                       needs='contact_sample')) call table%put(contact%largest_time)
    if (table%real_row('contact_force_error', 'event', 'N', estimate_of//'contact force', needs='contact_sample')) &
      call table%put(contact%force_error)
    if (table%real_row('contact_force', 'event contact_sample', 'N', 'contact force at Chebyshev''s points from begin to '// &
                       'end of each contact, (1 - cos(pi j/127))/2 of it')) call table%put_columns(contact%force)
  end subroutine contact_rows

  subroutine load_rows(table, loads)
    !! Put the applied loads.
    class(result_table), intent(inout) :: table
    type(load_result), intent(in), optional :: loads
    if (table%real_row('applied_force', 'force', 'N', 'largest magnitude of the force')) call table%put(loads%applied_force)
    if (table%real_row('applied_impulse', 'force', 'N s', 'impulse of the force')) call table%put(loads%applied_impulse)
    if (table%real_row('applied_acceleration', 'base', 'm s-2', 'largest magnitude of the acceleration of the base')) &
      call table%put(loads%applied_acceleration)
    if (table%real_row('applied_velocity', 'base', 'm s-1', 'velocity that the base has gained in the end')) &
      call table%put(loads%applied_velocity)
  end subroutine load_rows

  function values_of(result, name) result(values)
    !! Return the values of a real variable by its name, in SI; all missing if no modes were found. **Limits**: a scalar
    !! of the case, or one over modes, events or peaks.
    type(case_result), intent(in) :: result
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:)
    type(result_table) :: table
    call table%look_for(name)
    call case_rows(table, result)
    call move_alloc(table%found, values)
    if (result%mode_count == 0 .and. .not. allocated(result%record)) values = missing
  end function values_of

end module bw_case_rows
