module bw_result_variable
  !! A variable of the result that depends on the case, as one row: what the file says of it, when it is there, and where its
  !! values come from. The rows stand beside the procedures that they name, in bw_modal_variables, bw_event_variables and
  !! bw_history_variables.
  use bw_beam_units, only: beam_units
  use bw_case_result, only: case_result
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_netcdf, only: variable_text
  implicit none (type, external)
  private
  public :: case_variable, modal_variable, values_of_case, values_of_modes

  character(*), parameter, public :: unit_of_sensors = 'of the sensors'
    !! stands for the unit of what is measured, which a record's sensors tell; of simulated histories m

  type, extends(variable_text), public :: result_variable
    character(32) :: needs = ''
      !! what a result must have, beside the variable's dimensions, for the variable to be in it: words that `has` of
      !! bw_result_layout knows, by spaces
    procedure(values_of_case), pointer, nopass :: from_case => null()       !! where its values come from, or …
    procedure(values_of_modes), pointer, nopass :: from_modes => null()     !! … those of a variable of modes
  end type result_variable

  abstract interface
    pure subroutine values_of_case(result, values)
      !! The values of a variable in a case, in SI units.
      import :: case_result, dp
      implicit none (type, external)
      type(case_result), intent(in) :: result
      real(dp), intent(out), contiguous :: values(:)
        !! the first of them, as many as the case has; of two dimensions the last runs fastest. Integers as reals, which hold
        !! them exactly
    end subroutine values_of_case

    pure subroutine values_of_modes(modes, units, values)
      !! The values of a variable of modes, in SI units.
      import :: beam_units, dp, mode_set
      implicit none (type, external)
      class(mode_set), intent(in) :: modes              !! the set that the variable's dimension stands for
      type(beam_units), intent(in) :: units             !! of the case
      real(dp), intent(out), contiguous :: values(:)    !! of the first modes
    end subroutine values_of_modes
  end interface

contains

  pure function case_variable(text, values, needs) result(row)
    !! The row of a variable whose values are found in the case as a whole.
    type(variable_text), intent(in) :: text
    procedure(values_of_case) :: values
    character(*), intent(in), optional :: needs         !! beside its dimensions; absent: nothing
    type(result_variable) :: row
    row%variable_text = text
    row%from_case => values
    if (present(needs)) row%needs = needs
  end function case_variable

  pure function modal_variable(text, values) result(row)
    !! The row of a variable that any set of modes has, over `mode` or `mode_before`.
    type(variable_text), intent(in) :: text
    procedure(values_of_modes) :: values
    type(result_variable) :: row
    row%variable_text = text
    row%from_modes => values
  end function modal_variable

end module bw_result_variable
