module bw_modal_variables
  !! What a result holds of each mode: its rows, and behind them the procedures that give their values, which are named after
  !! them. What a procedure gives is said in its row.
  use bw_beam_units, only: beam_units
  use bw_case_result, only: case_result
  use bw_kinds, only: dp
  use bw_missing, only: missing, scaled
  use bw_modal_flow, only: find_angular_frequencies, find_growth_rates
  use bw_mode_set, only: mode_set
  use bw_netcdf, only: variable_text
  use bw_result_variable, only: case_variable, modal_variable, result_variable, values_of_modes
  implicit none (type, external)
  private
  public :: modal_variables

contains

  pure function modal_variables() result(rows)
    !! Of the modes in force after t = 0 over `mode`, and of those before a capture over `mode_before`.
    type(result_variable), allocatable :: rows(:)
    rows = [rows_of_set('mode', ''), rows_of_set('mode_before', '_before'), &
            case_variable(variable_text('mode_shape', 'mode profile', '1', 'mode shape', 'Eq. 18'), mode_shape, 'mode_shapes')]
  end function modal_variables

  pure function rows_of_set(dimension, suffix) result(rows)
    !! One set of modes.
    character(*), intent(in) :: dimension, suffix      !! suffix of the variables' names
    type(result_variable) :: rows(8)
    rows = [ &
      row('alpha', '1', 'wave number times length', 'Eq. 19', 'Eq. 8', alpha), &
      row('wavenumber', 'm-1', 'wave number P', 'Eq. 19', 'Eq. 8', wavenumber), &
      row('angular_frequency', 'rad s-1', 'angular frequency', 'Eq. 30', 'Eqs 2 and 10', angular_frequency), &
      row('growth_rate', 's-1', 'growth rate, the real part of the eigenvalue', 'Eq. 27', 'Eqs 2 and 10', growth_rate), &
      row('modal_mass', 'kg', 'modal mass', 'Eq. 21', 'Eq. 10', modal_mass), &
      velocity_row(suffix), &
      row('phase_velocity', 'm s-1', 'phase velocity', 'Eq. 32', 'Eq. 32', phase_velocity), &
      row('group_velocity', 'm s-1', 'group velocity', 'Eq. 33', 'Eq. 33', group_velocity)]
  contains
    pure type(result_variable) function row(name, units, long_name, equation, equation_before, values)
      !! The row of a variable that both sets have.
      character(*), intent(in) :: name, units, long_name
      character(*), intent(in) :: equation, equation_before       !! of the paper, for either set
      procedure(values_of_modes) :: values
      if (suffix == '') then
        row = modal_variable(variable_text(name, dimension, units, long_name, equation), values)
      else
        row = modal_variable(variable_text(name//suffix, dimension, units, long_name//', before the capture', &
                                           equation_before), values)
      end if
    end function row
  end function rows_of_set

  pure type(result_variable) function velocity_row(suffix) result(row)
    !! The modal velocities of the two sets mean different things.
    character(*), intent(in) :: suffix
    if (suffix == '') then
      row = case_variable(variable_text('modal_velocity', 'mode', 'm s-1', &
                                        'modal velocity just after the last event at t = 0', 'Eq. 26'), modal_velocity, 'event')
    else
      row = case_variable(variable_text('modal_velocity_before', 'mode_before', 'm s-1', &
                                        'jump of the modal velocity at the impact', 'Eq. 12'), modal_velocity_jump)
    end if
  end function velocity_row

  pure subroutine alpha(modes, units, values)
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    real(dp), intent(out), contiguous :: values(:)
    associate (unused => units)                        ! it has no unit
    end associate
    values = modes%alpha(:size(values))
  end subroutine alpha

  pure subroutine wavenumber(modes, units, values)
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    real(dp), intent(out), contiguous :: values(:)
    values = modes%alpha(:size(values))/units%length
  end subroutine wavenumber

  pure subroutine angular_frequency(modes, units, values)
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    real(dp), intent(out), contiguous :: values(:)
    call find_angular_frequencies(modes, values)
    values = scaled(values, units%frequency)
  end subroutine angular_frequency

  pure subroutine growth_rate(modes, units, values)
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    real(dp), intent(out), contiguous :: values(:)
    call find_growth_rates(modes, values)
    values = values*units%frequency
  end subroutine growth_rate

  pure subroutine modal_mass(modes, units, values)
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    real(dp), intent(out), contiguous :: values(:)
    values = modes%modal_mass(:size(values))*units%mass
  end subroutine modal_mass

  pure subroutine modal_velocity(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%modal_velocity(:size(values))*result%approach_velocity
  end subroutine modal_velocity

  pure subroutine modal_velocity_jump(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%impact%modal_velocity(:size(values))*result%approach_velocity
  end subroutine modal_velocity_jump

  pure subroutine mode_shape(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    integer :: j, n
    n = min(result%modes%count*result%profile_points, size(values))
    associate (last => result%profile_points - 1)
      values(:n) = pack(transpose(result%modes%some_shapes(1, n/(last + 1), [(real(j, dp)/last, j=0, last)])), .true.)
    end associate
    values(n + 1:) = missing
  end subroutine mode_shape

  pure subroutine phase_velocity(modes, units, values)
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    real(dp), intent(out), contiguous :: values(:)
    values = scaled(modes%phase_velocity(:size(values)), units%velocity)
  end subroutine phase_velocity

  pure subroutine group_velocity(modes, units, values)
    class(mode_set), intent(in) :: modes
    type(beam_units), intent(in) :: units
    real(dp), intent(out), contiguous :: values(:)
    values = scaled(modes%group_velocity(:size(values)), units%velocity)
  end subroutine group_velocity

end module bw_modal_variables
