module bw_history_rows
  !! The variables of histories in a result, of their spectra, and of responses to a harmonic force: a row for each, with values
  !! in SI.
  use bw_case_result, only: answer_type
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_measured, only: measured_type
  use bw_missing, only: is_missing, missing, scaled
  use bw_response, only: response_type, sampling_type
  use bw_result_table, only: result_table, unit_of_sensors
  implicit none (type, external)
  private
  public :: history_rows, largest_of, spectrum_rows

  character(*), parameter, public :: estimate_of = 'estimate of the largest error of the '
  character(*), parameter :: limit_of = '; with a capture, a contact that lasts or loads against infinitely many modes'

contains

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

  subroutine spectrum_rows(table, amplitude, answer, measured)
    !! Put amplitude spectra of histories, the response to a harmonic force, and measured waves.
    class(result_table), intent(inout) :: table
    real(dp), intent(in), optional, contiguous :: amplitude(:, :)  !! contiguous, or gfortran 12 packs an absent one
    type(answer_type), intent(in), optional :: answer
    type(measured_type), intent(in), optional :: measured
    if (table%real_row('amplitude', 'point frequency', unit_of_sensors, 'one-sided amplitude spectrum of the histories')) &
      call table%put_columns(amplitude)
    call answer_rows(table, answer)
    call measured_rows(table, measured)
  end subroutine spectrum_rows

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

end module bw_history_rows
