module bw_history_variables
  !! What a result holds of the histories of a case, of what is found in them, and of how the case ended: its rows, and behind
  !! them the procedures that give their values, which are named after them. What a procedure gives is said in its row.
  use bw_case_result, only: case_result, case_words
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_netcdf, only: variable_text
  use bw_result_variable, only: case_variable, result_variable, unit_of_sensors, values_of_case
  use bw_text, only: joined
  implicit none (type, external)
  private
  public :: error_variables, measured_variables, history_variables, count_variables

contains

  pure function error_variables() result(rows)
    !! Estimated errors of the histories.
    type(result_variable) :: rows(3)
    rows = [ &
      case_variable(variable_text('displacement_error', 'point', 'm', 'estimate of the largest error of the displacement; '// &
                                  'with a capture against infinitely many modes'), &
                    displacement_error, needs='estimates'), &
      case_variable(variable_text('velocity_error', 'point', 'm s-1', 'estimate of the largest error of the velocity; '// &
                                  'with a capture against infinitely many modes'), &
                    velocity_error, needs='estimates velocity'), &
      case_variable(variable_text('bending_moment_error', 'point', 'N m', 'estimate of the largest error of the bending '// &
                                  'moment; with a capture against infinitely many modes'), &
                    bending_moment_error, needs='estimates bending_moment')]
  end function error_variables

  pure function measured_variables() result(rows)
    !! Waves measured in the histories without any knowledge of the modes, and the bounds of their errors.
    type(result_variable) :: rows(8)
    rows = [ &
      measured('angular_frequency', 'rad s-1', '', angular_frequency), &
      measured('wavenumber', 'm-1', 'Eqs 18 and 20', wavenumber), &
      measured('phase_velocity', 'm s-1', '', phase_velocity), &
      measured('group_velocity', 'm s-1', '', group_velocity), &
      bound('angular_frequency', 'rad s-1', angular_frequency_error), &
      bound('wavenumber', 'm-1', wavenumber_error), &
      bound('phase_velocity', 'm s-1', phase_velocity_error), &
      bound('group_velocity', 'm s-1', group_velocity_error)]
    where (.not. index(rows%name, 'frequency') > 0) rows%needs = 'waves'
  end function measured_variables

  pure type(result_variable) function measured(name, units, references, values) result(row)
    !! A measured quantity.
    character(*), intent(in) :: name, units, references
    procedure(values_of_case) :: values
    row = case_variable(variable_text('measured_'//name, 'peak', units, in_words(name)//' measured in the histories', &
                                      references), values)
  end function measured

  pure type(result_variable) function bound(name, units, values) result(row)
    !! How far a measured quantity may be off.
    character(*), intent(in) :: name, units
    procedure(values_of_case) :: values
    row = case_variable(variable_text('measured_'//name//'_error', 'peak', units, &
                                      'bound of the error of the measured '//in_words(name)// &
                                      ', of a record half its interval'), values)
  end function bound

  pure function in_words(name) result(words)
    !! `phase_velocity` as phase velocity; `wavenumber` as wave number.
    character(*), intent(in) :: name
    character(:), allocatable :: words
    integer :: gap
    words = name
    gap = index(words, '_')
    if (gap > 0) words(gap:gap) = ' '
    if (words == 'wavenumber') words = 'wave number'
  end function in_words

  pure function history_variables() result(rows)
    !! Histories and spectra, a result's large arrays.
    type(result_variable) :: rows(4)
    rows = [ &
      case_variable(variable_text('displacement', 'point time', 'm', 'transverse displacement in the rotating frame', &
                                  'Eqs 4, 13 and 29'), displacement, needs='simulated'), &
      case_variable(variable_text('velocity', 'point time', 'm s-1', 'transverse velocity in the rotating frame'), velocity, &
                    needs='velocity'), &
      case_variable(variable_text('bending_moment', 'point time', 'N m', 'bending moment EI v'''', with shear EI psi'''), &
                    bending_moment, needs='bending_moment'), &
      case_variable(variable_text('amplitude', 'point frequency', unit_of_sensors, &
                                  'one-sided amplitude spectrum of the histories'), amplitude)]
  end function history_variables

  pure function count_variables() result(rows)
    !! Counts, and how the case ended.
    type(result_variable) :: rows(3)
    rows = [ &
      case_variable(variable_text('mode_count', '', '1', 'number of modes', is_integer=.true.), mode_count, &
                    needs='mode'), &
      case_variable(variable_text('peak_count', '', '1', 'number of measured peaks', is_integer=.true.), peak_count, &
                    needs='peak'), &
      case_variable(variable_text('case_status', '', '1', 'how the case ended', is_integer=.true., &
                                  flags=joined(case_words)), case_status)]
  end function count_variables

  pure subroutine displacement_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = missing
    if (allocated(result%response%displacement_error)) values = result%response%displacement_error(:size(values))
  end subroutine displacement_error

  pure subroutine velocity_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = missing
    if (allocated(result%response%velocity_error)) values = result%response%velocity_error(:size(values))
  end subroutine velocity_error

  pure subroutine bending_moment_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = missing
    if (allocated(result%response%bending_moment_error)) values = result%response%bending_moment_error(:size(values))
  end subroutine bending_moment_error

  pure subroutine angular_frequency(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%angular_frequency(:size(values))
  end subroutine angular_frequency

  pure subroutine angular_frequency_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%angular_frequency_error(:size(values))
  end subroutine angular_frequency_error

  pure subroutine wavenumber(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%wavenumber(:size(values))
  end subroutine wavenumber

  pure subroutine wavenumber_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%wavenumber_error(:size(values))
  end subroutine wavenumber_error

  pure subroutine phase_velocity(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%phase_velocity(:size(values))
  end subroutine phase_velocity

  pure subroutine phase_velocity_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%phase_velocity_error(:size(values))
  end subroutine phase_velocity_error

  pure subroutine group_velocity(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%group_velocity(:size(values))
  end subroutine group_velocity

  pure subroutine group_velocity_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%group_velocity_error(:size(values))
  end subroutine group_velocity_error

  pure subroutine displacement(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call flatten(result%response%displacement, values)
  end subroutine displacement

  pure subroutine velocity(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call flatten(result%response%velocity, values)
  end subroutine velocity

  pure subroutine bending_moment(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call flatten(result%response%bending_moment, values)
  end subroutine bending_moment

  pure subroutine amplitude(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call flatten(result%amplitude, values)
  end subroutine amplitude

  pure subroutine flatten(matrix, values)
    !! A history or spectrum column by column; missing where there is none.
    real(dp), intent(in), optional :: matrix(:, :)        !! (samples or frequencies, points); absent: it is not finished
    real(dp), intent(out), contiguous :: values(:)
    integer :: j, n
    if (.not. present(matrix)) then
      values = missing
      return
    end if
    n = size(matrix, 1)
    do j = 1, size(matrix, 2)
      values((j - 1)*n + 1:j*n) = matrix(:, j)
    end do
  end subroutine flatten

  pure subroutine mode_count(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%mode_count
  end subroutine mode_count

  pure subroutine peak_count(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%measured%peak_count
  end subroutine peak_count

  pure subroutine case_status(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%status
  end subroutine case_status

end module bw_history_variables
