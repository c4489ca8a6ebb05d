module bw_case_fields
  !! What the result file holds of a case, as one list of fields, and a case's numbers in that order: each field as long as
  !! its dimensions say, with fill where the case has less. All cases of a scene have the same length. Long histories and
  !! spectra, which are most of a case, come last: they go into the file one by one, all else by blocks of cases.
  use bw_kinds, only: dp, i8
  use bw_case_result, only: case_result
  use bw_event, only: no_event
  use bw_missing, only: missing
  use bw_result_layout, only: dimension_length, has_dimension, result_layout
  use bw_result_table, only: is_held, variable_row, variable_table
  use bw_result_values, only: key_of, put_value, value_key
  implicit none (type, external)
  private
  public :: fields_of, case_length, short_fields, put_field, put_fields

  integer(i8), parameter :: long = 512          !! numbers of a history that is long: some pages of a file; tuned

  type, public :: case_field
    !! A variable that depends on the case.
    character(32) :: name = ''
    integer :: lengths(2) = 1          !! of its own dimensions, fastest first
    integer :: rank = 0                !! how many dimensions it has besides `case`
    logical :: is_integer = .false.
    integer(i8) :: first = 1           !! where its numbers begin among those of the case
    integer(i8) :: length = 1          !! how many it has
    type(value_key), private :: key    !! of a variable of the table
    integer, private :: other = 0      !! place among `other_names`; 0: a variable of the table
  end type case_field

  character(*), parameter :: other_names(*) = [character(12) :: 'displacement', 'velocity', 'amplitude', 'event_kind', &
    'peak_count', 'mode_count', 'case_status']      !! of histories and integers

contains

  pure function fields_of(layout) result(fields)
    !! All that a result of this layout holds; `case_status` is the last of those that are not long.
    type(result_layout), intent(in) :: layout
    type(case_field), allocatable :: fields(:)
    type(variable_row), allocatable :: table(:)
    integer :: i
    allocate (fields(0))
    table = variable_table()
    do i = 1, size(table)
      if (is_held(layout, table(i))) call add_row(layout, table(i), fields)
    end do
    if (has_dimension(layout, 'time')) then
      call add(layout, fields, 'displacement', 'time', 'point')
      if (layout%velocity) call add(layout, fields, 'velocity', 'time', 'point')
    end if
    if (has_dimension(layout, 'frequency')) call add(layout, fields, 'amplitude', 'frequency', 'point')
    if (has_dimension(layout, 'event')) call add_integer(layout, fields, 'event_kind', 'event')
    if (has_dimension(layout, 'peak')) call add_integer(layout, fields, 'peak_count')
    call add_integer(layout, fields, 'mode_count')
    call add_integer(layout, fields, 'case_status')
    fields = [pack(fields, .not. is_long(fields)), pack(fields, is_long(fields))]
    do i = 1, size(fields)
      fields(i)%first = 1 + case_length(fields(:i - 1))
    end do
  end function fields_of

  elemental logical function is_long(field)
    !! A history or spectrum that is worth a write of its own.
    type(case_field), intent(in) :: field
    is_long = field%rank == 2 .and. field%length >= long
  end function is_long

  pure integer function short_fields(fields)
    !! How many there are before the long ones.
    type(case_field), intent(in) :: fields(:)
    short_fields = count(.not. is_long(fields))
  end function short_fields

  pure subroutine add_row(layout, row, fields)
    !! A variable of the table.
    type(result_layout), intent(in) :: layout
    type(variable_row), intent(in) :: row
    type(case_field), allocatable, intent(inout) :: fields(:)
    if (row%dimensions == '') then
      call add(layout, fields, row%name)
    else
      call add(layout, fields, row%name, trim(row%dimensions))
    end if
    fields(size(fields))%key = key_of(row)
    fields(size(fields))%other = 0
  end subroutine add_row

  pure subroutine add_integer(layout, fields, name, dimension)
    type(result_layout), intent(in) :: layout
    type(case_field), allocatable, intent(inout) :: fields(:)
    character(*), intent(in) :: name
    character(*), intent(in), optional :: dimension
    call add(layout, fields, name, dimension)
    fields(size(fields))%is_integer = .true.
  end subroutine add_integer

  pure subroutine add(layout, fields, name, fastest, slowest)
    !! One more field, behind the others.
    type(result_layout), intent(in) :: layout
    type(case_field), allocatable, intent(inout) :: fields(:)
    character(*), intent(in) :: name
    character(*), intent(in), optional :: fastest, slowest      !! names of its dimensions
    type(case_field) :: field
    field%name = name
    field%other = findloc(other_names == name, .true., dim=1)
    if (present(fastest)) then
      field%rank = 1
      field%lengths(1) = dimension_length(layout, fastest)
    end if
    if (present(slowest)) then
      field%rank = 2
      field%lengths(2) = dimension_length(layout, slowest)
    end if
    field%first = case_length(fields) + 1
    field%length = product(int(field%lengths, i8))
    fields = [fields, field]
  end subroutine add

  pure integer(i8) function case_length(fields)
    !! How many numbers a case has.
    type(case_field), intent(in) :: fields(:)
    case_length = 0
    if (size(fields) > 0) case_length = fields(size(fields))%first + fields(size(fields))%length - 1
  end function case_length

  pure subroutine put_fields(result, fields, numbers)
    !! A case as numbers, or the part of it that these fields are.
    type(case_result), intent(in) :: result
    type(case_field), intent(in) :: fields(:)             !! the first of them, or all
    real(dp), intent(out), contiguous :: numbers(:)       !! (case_length)
    integer :: i
    do i = 1, size(fields)
      associate (field => fields(i))
        call put_field(result, field, numbers(field%first:field%first + field%length - 1))
      end associate
    end do
  end subroutine put_fields

  pure subroutine put_field(result, field, numbers)
    !! A case's numbers of one field; integers as reals, which hold them exactly.
    type(case_result), intent(in) :: result
    type(case_field), intent(in) :: field
    real(dp), intent(out), contiguous :: numbers(:)       !! (field%length)
    select case (field%other)     ! by places in other_names
    case (0); call put_value(result, field%key, numbers)
    case (1); call copy_matrix(result%response%displacement, numbers)
    case (2); call copy_matrix(result%response%velocity, numbers)
    case (3); call copy_matrix(result%amplitude, numbers)
    case (4); call copy(result%events%kind, no_event, numbers)
    case (5); numbers = result%measured%peak_count
    case (6); numbers = result%mode_count
    case default; numbers = result%status
    end select
  end subroutine put_field

  pure subroutine copy(values, fill, numbers)
    !! Values, and fill behind them.
    integer, intent(in) :: values(:), fill
    real(dp), intent(out) :: numbers(:)
    integer :: n
    n = min(size(values), size(numbers))
    numbers(:n) = values(:n)
    numbers(n + 1:) = fill
  end subroutine copy

  pure subroutine copy_matrix(values, numbers)
    !! A history or spectrum; fill where there is none.
    real(dp), intent(in), optional :: values(:, :)        !! fastest dimension first; absent: not finished
    real(dp), intent(out), contiguous :: numbers(:)
    integer :: j, n
    if (.not. present(values)) then
      numbers = missing
      return
    end if
    n = size(values, 1)
    do j = 1, size(values, 2)
      numbers((j - 1)*n + 1:j*n) = values(:, j)
    end do
  end subroutine copy_matrix

end module bw_case_fields
