module bw_case_rows
  !! The variables of a case in a result: a row for each, with values in SI. A case itself has masses in units of m_i
  !! and velocities in units of the approach velocity V.
  use bw_beam_units, only: beam_units, in_joules, in_newton_seconds
  use bw_case_result, only: answer_type, case_result, contact_result, load_result
  use bw_event, only: event_type, event_words
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_measured, only: measured_type
  use bw_missing, only: is_missing, missing, scaled
  use bw_modal_flow, only: find_angular_frequencies, find_growth_rates
  use bw_mode_set, only: mode_set
  use bw_model_rows, only: model_rows
  use bw_record_rows, only: record_rows
  use bw_response, only: response_type, sampling_type
  use bw_result_table, only: result_table, unit_of_sensors
  implicit none (type, external)
  private
  public :: all_modes, case_rows, starts_of, values_of

  character(*), parameter :: of_blow = 'Eq. 12, reference [8]', estimate_of = 'estimate of the largest error of the ', &
    limit_of = '; with a capture, a contact that lasts or loads against infinitely many modes', &
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
    if (table%real_row('amplitude', 'point frequency', unit_of_sensors, 'one-sided amplitude spectrum of the histories')) &
      call table%put_columns(result%amplitude)
    call answer_rows(table, result%answer)
    call measured_rows(table, result%measured)
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

  subroutine history_rows(table, response)
    !! Put histories, their peaks and their errors.
    class(result_table), intent(inout) :: table
    type(response_type), intent(in), optional :: response
    if (table%real_row('largest_displacement', 'point', 'm', 'largest sample of the displacement', needs='simulated', &
                       summary=.true.)) call table%put(largest_of(response%displacement))
    if (table%real_row('largest_displacement_time', 'point', 's', 'time of that sample', needs='simulated')) &
      call table%put(times_of_largest(response%displacement, response%sampling))
    if (table%real_row('largest_stress', 'point', 'Pa', 'largest sample of the bending stress', needs='bending_stress', &
                       summary=.true.)) call table%put(largest_of(stresses_of(response)))
    if (table%real_row('largest_stress_time', 'point', 's', 'time of that sample', needs='bending_stress')) &
      call table%put(times_of_largest(stresses_of(response), response%sampling))
    if (table%real_row('displacement_error', 'point', 'm', estimate_of//'displacement'//limit_of, needs='estimates')) &
      call table%put(response%displacement_error)
    if (table%real_row('displacement_bound', 'point', 'm', 'bound of the error of the displacement against infinitely many '// &
                       'modes, proved', needs='continuum')) &
      call table%put(response%displacement_bound)
    if (table%real_row('velocity_error', 'point', 'm s-1', estimate_of//'velocity'//limit_of, needs='estimates velocity')) &
      call table%put(response%velocity_error)
    if (table%real_row('bending_moment_error', 'point', 'N m', estimate_of//'bending moment'//limit_of, &
                       needs='estimates bending_moment')) call table%put(response%bending_moment_error)
    if (table%real_row('acceleration_error', 'point', 'm s-2', estimate_of//'acceleration'//limit_of, &
                       needs='estimates acceleration')) call table%put(response%acceleration_error)
    if (table%real_row('shear_force_error', 'point', 'N', estimate_of//'shear force'//limit_of, &
                       needs='estimates shear_force')) call table%put(response%shear_force_error)
    if (table%real_row('bending_stress_error', 'point', 'Pa', estimate_of//'bending stress'//limit_of, &
                       needs='estimates bending_stress')) call put_stress_errors(table, response)
    if (table%real_row('hub_angle', 'time', 'rad', 'turn of the hub beyond the even rotation', needs='hub')) &
      call table%put(response%hub_angle)
    if (table%real_row('displacement', 'point time', 'm', 'transverse displacement in the rotating frame', &
                       'Eqs 4, 13 and 29', needs='simulated')) call table%put_columns(response%displacement)
    if (table%real_row('velocity', 'point time', 'm s-1', 'transverse velocity in the rotating frame', needs='velocity')) &
      call table%put_columns(response%velocity)
    if (table%real_row('acceleration', 'point time', 'm s-2', 'transverse acceleration in the rotating frame', &
                       needs='acceleration')) call table%put_columns(response%acceleration)
    if (table%real_row('shear_force', 'point time', 'N', 'shear force, by which what lies beyond pulls, at the root '// &
                       'what the beam does to its support', needs='shear_force')) call table%put_columns(response%shear_force)
    if (table%real_row('bending_moment', 'point time', 'N m', 'bending moment EI v'''', with shear EI psi''', &
                       needs='bending_moment')) call table%put_columns(response%bending_moment)
    if (table%real_row('bending_stress', 'point time', 'Pa', 'bending stress at the extreme fibre, where a positive moment pulls', &
                       needs='bending_stress')) &
      call table%put_columns(stresses_of(response))
  end subroutine history_rows

  subroutine put_stress_errors(table, response)
    !! Put errors of stresses: those of moments times c/I; fill if there are none.
    class(result_table), intent(inout) :: table
    type(response_type), intent(in) :: response
    if (allocated(response%bending_moment_error)) then
      call table%put(scaled(response%bending_moment_error, response%stress_of_moment))
    else
      call table%put(response%bending_moment_error)
    end if
  end subroutine put_stress_errors

  pure function stresses_of(response) result(stress)
    !! Return stresses M c/I, (samples, points).
    type(response_type), intent(in) :: response
    real(dp), allocatable :: stress(:, :)
    integer :: p
    stress = response%bending_moment
    do p = 1, size(stress, 2)
      stress(:, p) = scaled(stress(:, p), response%stress_of_moment(p))
    end do
  end function stresses_of

  subroutine answer_rows(table, answer)
    !! Put the response to a harmonic force.
    class(result_table), intent(inout) :: table
    type(answer_type), intent(in), optional :: answer
    character(*), parameter :: name = 'frequency_response_', of_answer = ' of the response to a force of 1 N: the '
    character(:), allocatable :: unit, quantity
    quantity = trim(table%layout%answer)
    select case (quantity)
    case ('velocity'); unit = 'm s-1 N-1'
    case ('acceleration'); unit = 'm s-2 N-1'
    case default; unit = 'm N-1'
    end select
    if (table%real_row(name//'real', 'point response_frequency', unit, 'real part'//of_answer//quantity)) &
      call table%put_columns(answer%value%re)
    if (table%real_row(name//'imag', 'point response_frequency', unit, 'imaginary part'//of_answer//quantity)) &
      call table%put_columns(answer%value%im)
    if (table%real_row(name//'error', 'point', unit, estimate_of//'response to a harmonic force', needs='by_modes')) &
      call table%put(answer%error)
    if (table%real_row('junction_position', 'junction', '1', 'x/l of a body or a step of the section within the beam')) &
      call table%put(answer%junction)
    if (scattered('transmitted')) call table%put_columns(answer%transmitted)
    if (scattered('reflected')) call table%put_columns(answer%reflected)
  contains
    logical function scattered(way)
      character(*), intent(in) :: way
      scattered = table%real_row(way//'_power', 'junction response_frequency', '1', 'share of the power of a bending wave from '// &
                                 'the root''s side that is '//way//' at the junction')
    end function scattered
  end subroutine answer_rows

  pure function largest_of(histories) result(largest)
    !! Return the largest known magnitude at each point; missing if none is known.
    real(dp), intent(in) :: histories(:, :)            !! (samples, points)
    real(dp) :: largest(size(histories, 2))
    integer :: p
    do p = 1, size(largest)
      largest(p) = largest_magnitude(histories(:, p))
      if (largest(p) < missing) cycle
      largest(p) = missing
      if (any(.not. is_missing(histories(:, p)))) largest(p) = maxval(abs(histories(:, p)), mask=.not. is_missing(histories(:, p)))
    end do
  end function largest_of

  pure function times_of_largest(histories, sampling) result(times)
    !! Return when the largest known magnitude first occurs at each point, s; missing if none is known.
    real(dp), intent(in) :: histories(:, :)            !! (samples, points)
    type(sampling_type), intent(in) :: sampling
    real(dp) :: times(size(histories, 2))
    integer :: p, at
    times = missing
    do p = 1, size(times)
      at = maxloc(abs(histories(:, p)), dim=1, mask=.not. is_missing(histories(:, p)))
      if (at > 0) times(p) = (at - 1)*sampling%grid%step%hi*sampling%unit_time
    end do
  end function times_of_largest

  subroutine measured_rows(table, measured)
    !! Put waves measured in the histories without knowledge of the modes, and their error bounds.
    class(result_table), intent(inout) :: table
    type(measured_type), intent(in), optional :: measured
    if (row('angular_frequency', 'rad s-1', 'angular frequency', '')) call table%put(measured%angular_frequency)
    if (row('wavenumber', 'm-1', 'wave number', 'Eqs 18 and 20', 'waves')) call table%put(measured%wavenumber)
    if (row('phase_velocity', 'm s-1', 'phase velocity', '', 'waves')) call table%put(measured%phase_velocity)
    if (row('group_velocity', 'm s-1', 'group velocity', '', 'waves')) call table%put(measured%group_velocity)
    if (bound('angular_frequency', 'rad s-1', 'angular frequency')) call table%put(measured%angular_frequency_error)
    if (bound('wavenumber', 'm-1', 'wave number', 'waves')) call table%put(measured%wavenumber_error)
    if (bound('phase_velocity', 'm s-1', 'phase velocity', 'waves')) call table%put(measured%phase_velocity_error)
    if (bound('group_velocity', 'm s-1', 'group velocity', 'waves')) call table%put(measured%group_velocity_error)
    if (table%whole_row('peak_count', '', 'number of measured peaks', needs='peak')) call table%put([measured%peak_count])
  contains
    logical function row(name, units, words, references, needs)
      character(*), intent(in) :: name, units, words, references
      character(*), intent(in), optional :: needs
      row = table%real_row('measured_'//name, 'peak', units, words//' measured in the histories', references, needs)
    end function row
    logical function bound(name, units, words, needs)
      character(*), intent(in) :: name, units, words
      character(*), intent(in), optional :: needs
      bound = table%real_row('measured_'//name//'_error', 'peak', units, 'bound of the error of the measured '//words// &
                             ', of a record half its interval', needs=needs)
    end function bound
  end subroutine measured_rows

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
