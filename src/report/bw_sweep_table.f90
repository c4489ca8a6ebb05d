module bw_sweep_table
  !! The printed table of a sweep: its first cases, each with the values that it was given, in their order however they come.
  use bw_kinds, only: dp, i8
  use bw_case_fields, only: case_field, fields_of
  use bw_missing, only: missing
  use bw_report, only: case_heading, case_line
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_positions
  use bw_text, only: string, text_builder, text_of
  implicit none (type, external)
  private

  integer, parameter :: shown_cases = 20      !! rows

  character(*), parameter :: column_names(*) = &
    [character(17) :: 'mode_count', 'angular_frequency', 'phase_velocity', 'group_velocity', 'displacement']

  type, public :: sweep_table
    private
    integer(i8) :: cases = 0
    type(string) :: swept(shown_cases), lines(shown_cases)
    type(case_field) :: columns(size(column_names))
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
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(sweep_table) :: table
    type(case_field), allocatable :: fields(:)
    integer :: i, f
    fields = fields_of(layout)
    table%cases = layout%cases
    do i = 1, size(column_names)
      do f = 1, size(fields)
        if (fields(f)%name == column_names(i)) table%columns(i) = fields(f)
      end do
    end do
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
    !! Take the row of a case that has one from its numbers.
    class(sweep_table), intent(inout) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(in) :: numbers(:)        !! (case_length)
    real(dp) :: largest
    largest = missing
    associate (c => self%columns)
      if (c(5)%name /= '') then
        associate (history => numbers(c(5)%first:c(5)%first + c(5)%length - 1))
          if (any(history /= missing)) largest = maxval(abs(history), mask=history /= missing)
        end associate
      end if
      self%lines(index)%text = case_line(int(index), self%swept(index)%text, nint(numbers(c(1)%first)), &
                                         [numbers(c(2:4)%first), largest])
    end associate
  end subroutine add

  function text(self) result(lines)
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

end module bw_sweep_table
