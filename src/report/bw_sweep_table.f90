module bw_sweep_table
  !! The printed table of a sweep: its first cases, each with the values that it was given, in their order however they come.
  use bw_kinds, only: dp, i8
  use bw_case_fields, only: case_field, field_of, fields_of
  use bw_columns, only: fixed, right
  use bw_missing, only: missing
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_positions
  use bw_text, only: string, text_builder, text_of
  implicit none (type, external)
  private

  integer, parameter :: shown_cases = 20      !! rows

  type, public :: sweep_table
    private
    integer(i8) :: cases = 0
    type(string) :: swept(shown_cases), lines(shown_cases)
    type(case_field) :: mode_count, frequency, phase_velocity, group_velocity, displacement     !! where they stand in a case
  contains
    procedure :: shows
    procedure :: add
    procedure :: text
  end type sweep_table

  interface sweep_table
    module procedure :: table_of
  end interface sweep_table

contains

  function table_of(scene, layout) result(table)
    !! A table without rows, in which the swept values of its cases are known.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(sweep_table) :: table
    integer :: i
    associate (fields => fields_of(layout))
      table%mode_count = field_of(fields, 'mode_count')
      table%frequency = field_of(fields, 'angular_frequency')
      table%phase_velocity = field_of(fields, 'phase_velocity')
      table%group_velocity = field_of(fields, 'group_velocity')
      table%displacement = field_of(fields, 'displacement')
    end associate
    table%cases = layout%cases
    do i = 1, int(min(table%cases, int(shown_cases, i8)))
      table%swept(i)%text = swept_text(scene, int(i, i8))
    end do
  end function table_of

  function swept_text(scene, i) result(text)
    !! The swept values of a case: 'name = value, …'.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: i
    character(:), allocatable :: text
    integer :: positions(size(scene%sweeps)), s
    positions = case_positions(scene, i)
    text = ''
    do s = 1, size(scene%sweeps)
      if (s > 1) text = text//', '
      text = text//scene%sweeps(s)%parameter//' = '//text_of(scene%sweeps(s)%values(positions(s)))
    end do
  end function swept_text

  pure logical function shows(self, index)
    !! Whether a case has a row.
    class(sweep_table), intent(in) :: self
    integer(i8), intent(in) :: index
    shows = index <= size(self%lines)
  end function shows

  subroutine add(self, index, numbers)
    !! Make the row of a case that has one from its numbers.
    class(sweep_table), intent(inout) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(in) :: numbers(:)        !! (case_length)
    real(dp) :: largest
    largest = missing
    if (self%displacement%name /= '') then
      associate (first => self%displacement%first, length => self%displacement%length)
        associate (history => numbers(first:first + length - 1))
          if (any(history /= missing)) largest = maxval(abs(history), mask=history /= missing)
        end associate
      end associate
    end if
    self%lines(index)%text = case_line(int(index), self%swept(index)%text, nint(numbers(self%mode_count%first)), &
                                       [numbers(self%frequency%first), numbers(self%phase_velocity%first), &
                                        numbers(self%group_velocity%first), largest])
  end subroutine add

  function text(self) result(lines)
    !! The table as it is printed.
    class(sweep_table), intent(in) :: self
    character(:), allocatable :: lines
    type(text_builder) :: rows
    integer :: i
    call rows%append(new_line('a')//case_heading())
    do i = 1, size(self%lines)
      if (allocated(self%lines(i)%text)) call rows%append(self%lines(i)%text)
    end do
    if (self%cases > shown_cases) call rows%append_line('     ...   '//text_of(self%cases)//' cases in all')
    lines = rows%text()
  end function text

  function case_heading() result(text)
    !! Heads the rows of `case_line`.
    character(:), allocatable :: text
    text = '    case   modes  mode 1: frequency  phase velocity  group velocity    displacement   swept'//new_line('a')// &
           '                              rad/s             m/s             m/s   m, largest'//new_line('a')
  end function case_heading

  function case_line(case_number, swept, modes, numbers) result(text)
    !! One line of a sweep.
    integer, intent(in) :: case_number
    character(*), intent(in) :: swept             !! 'name = value, …'
    integer, intent(in) :: modes                  !! how many were summed
    real(dp), intent(in) :: numbers(4)            !! of the columns that follow; fill where there is none
    character(:), allocatable :: text
    text = right(text_of(case_number), 8)//right(text_of(modes), 8)//right(fixed(numbers(1)), 19)// &
      right(fixed(numbers(2)), 16)//right(fixed(numbers(3)), 16)//right(fixed(numbers(4)), 16)//'   '//swept// &
      new_line('a')
  end function case_line

end module bw_sweep_table
