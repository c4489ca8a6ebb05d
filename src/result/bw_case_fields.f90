module bw_case_fields
  !! A case as one list of numbers. Every variable that depends on the case is a field of it, as long as its dimensions say,
  !! with fill where the case has less, so that all cases of a scene have the same length. Long histories and spectra, which
  !! are most of a case, come last. Cases go into the file by blocks: of the long fields a few, of the others many.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_kinds, only: dp, i8
  use bw_case_result, only: case_done, case_not_converged, case_result
  use bw_event_variables, only: event_kinds, event_variables, impact_variables
  use bw_history_variables, only: count_variables, error_variables, history_variables, measured_variables
  use bw_missing, only: missing
  use bw_modal_variables, only: modal_variables
  use bw_record_variables, only: record_variables
  use bw_text, only: append
  use bw_result_layout, only: dimension_length, dimension_names, has, result_layout
  use bw_result_variable, only: result_variable, unit_of_sensors
  implicit none (type, external)
  private
  public :: all_variables, blocks_for, case_length, field_of, fields_of, forbid_lost, named_value, put_field, put_fields, &
    variables_of

  integer(i8), parameter :: long = 512                  !! numbers of a history that is long: some pages of a file; tuned
  integer(i8), parameter :: block_numbers = 1000000     !! 8 MB of short fields are written at a time; a single case may be more
  integer(i8), parameter :: long_numbers = 65536        !! of long fields what stays in a cache; tuned

  integer, parameter :: no_dimension = 0, along_modes = findloc(dimension_names == 'mode', .true., dim=1), &
    along_modes_before = findloc(dimension_names == 'mode_before', .true., dim=1), &
    along_events = findloc(dimension_names == 'event', .true., dim=1), &
    along_peaks = findloc(dimension_names == 'peak', .true., dim=1)

  type, extends(result_variable), public :: case_field
    !! A variable as a stretch of the numbers of a case.
    integer :: lengths(2) = 1          !! of its own dimensions, fastest first
    integer :: rank = 0                !! how many dimensions it has besides `case`
    integer(i8) :: first = 1           !! where its numbers begin among those of the case
    integer(i8) :: length = 1          !! how many it has
    integer, private :: along = no_dimension
      !! place of its only dimension among `dimension_names`, as its number of values may differ from case to case
  end type case_field

  type, public :: case_block
    !! Some fields of some neighbouring cases on their way to the result file. They lie field by field: all numbers of a field
    !! together, as they are written.
    type(case_field), allocatable :: fields(:)
    integer :: before = 0              !! how many fields of a case stand before these
    integer :: capacity = 0            !! how many cases it has room for
    integer :: count = 0               !! how many there are
    integer(i8) :: first = 1           !! the number of the first of them
    real(dp), allocatable :: numbers(:)    !! (numbers of these fields of a case · capacity)
  contains
    procedure :: takes
    procedure :: add => add_case
    procedure :: begin_of
  end type case_block

contains

  pure function all_variables() result(rows)
    !! Every variable that a result may hold of a case, in the order of the file.
    type(result_variable), allocatable :: rows(:)
    rows = some_variables(.true.)
  end function all_variables

  pure function some_variables(with_record) result(rows)
    !! The same, with those that only results of records have, or without them: there are many.
    logical, intent(in) :: with_record
    type(result_variable), allocatable :: rows(:), of_record(:)
    allocate (of_record(0))
    if (with_record) of_record = record_variables()
    rows = [modal_variables(), impact_variables(), event_variables(), error_variables(), measured_variables(), &
            history_variables(), of_record, count_variables(), event_kinds()]
  end function some_variables

  pure function variables_of(layout) result(rows)
    !! Those that a result of this layout holds.
    type(result_layout), intent(in) :: layout
    type(result_variable), allocatable :: rows(:)
    integer :: i
    rows = some_variables(layout%of_record)
    rows = pack(rows, [(has(layout, trim(rows(i)%dimensions)) .and. has(layout, trim(rows(i)%needs)), i=1, size(rows))])
    do i = 1, size(rows)
      if (rows(i)%units /= unit_of_sensors) cycle
      rows(i)%units = 'm'
      if (allocated(layout%record)) rows(i)%units = layout%record%unit
    end do
  end function variables_of

  pure function fields_of(layout) result(fields)
    !! The fields of a case of this layout in the order of its numbers, the long ones last.
    type(result_layout), intent(in) :: layout
    type(case_field), allocatable :: fields(:)
    type(result_variable), allocatable :: rows(:)
    integer :: i
    rows = variables_of(layout)
    allocate (fields(size(rows)))
    do i = 1, size(rows)
      fields(i) = field_of_row(layout, rows(i))
    end do
    fields = [pack(fields, .not. is_long(fields)), pack(fields, is_long(fields))]
    do i = 2, size(fields)
      fields(i)%first = fields(i - 1)%first + fields(i - 1)%length
    end do
  end function fields_of

  pure type(case_field) function field_of_row(layout, row) result(field)
    !! A variable with its lengths.
    type(result_layout), intent(in) :: layout
    type(result_variable), intent(in) :: row
    integer :: gap
    field%result_variable = row
    if (row%dimensions == '') return
    gap = index(trim(row%dimensions), ' ')
    field%lengths(1) = dimension_length(layout, trim(row%dimensions(gap + 1:)))
    field%rank = 1
    if (gap > 0) then
      field%lengths(2) = dimension_length(layout, row%dimensions(:gap - 1))
      field%rank = 2
    else
      field%along = findloc(dimension_names == row%dimensions, .true., dim=1)
    end if
    field%length = product(int(field%lengths, i8))
  end function field_of_row

  elemental logical function is_long(field)
    !! A history or spectrum that is worth a write of its own.
    type(case_field), intent(in) :: field
    is_long = field%rank == 2 .and. field%length >= long
  end function is_long

  pure type(case_field) function field_of(fields, name) result(field)
    !! The field of a name; one of no name and one number where there is none.
    type(case_field), intent(in) :: fields(:)
    character(*), intent(in) :: name
    integer :: i
    i = findloc(fields%name == name, .true., dim=1)
    if (i > 0) field = fields(i)
  end function field_of

  pure integer(i8) function case_length(fields)
    !! How many numbers a case has.
    type(case_field), intent(in) :: fields(:)
    case_length = sum(fields%length)
  end function case_length

  pure subroutine put_fields(result, fields, numbers, lost)
    !! The numbers of a case, of all its fields or of the first of them.
    type(case_result), intent(in) :: result
    type(case_field), intent(in) :: fields(:)             !! the first of them, or all
    real(dp), intent(out), contiguous :: numbers(:)       !! (case_length)
    logical, intent(out), optional :: lost                !! as that of `put_field`, of any of them
    logical :: one
    integer :: i
    if (present(lost)) lost = .false.
    do i = 1, size(fields)
      associate (field => fields(i))
        call put_field(result, field, numbers(field%first:field%first + field%length - 1), one)
        if (present(lost)) lost = lost .or. one
      end associate
    end do
  end subroutine put_fields

  pure subroutine forbid_lost(result, fields)
    !! The last gate: a case that holds NaN or infinity, which no stage should leave, cannot be trusted and says where.
    type(case_result), intent(inout) :: result
    type(case_field), intent(in) :: fields(:)
    real(dp), allocatable :: numbers(:)
    character(:), allocatable :: names
    logical :: lost
    integer :: i
    names = ''
    do i = 1, size(fields)
      allocate (numbers(fields(i)%length))
      call put_field(result, fields(i), numbers, lost)
      if (lost) names = names//', '//trim(fields(i)%name)
      deallocate (numbers)
    end do
    if (names == '') return
    if (result%status == case_done) result%status = case_not_converged
    call append(result%notes, 'not converged: rounding has left no numbers in '//names(3:)//', which hold fill there. This is '// &
                'a fault of the program: please report it with the scene')
  end subroutine forbid_lost

  pure subroutine put_field(result, field, numbers, lost)
    !! A case's numbers of one field, in SI units; fill behind them and for what is no number, and all fill where no modes were
    !! found. Integers, which always exist, are filled with 0.
    type(case_result), intent(in) :: result
    type(case_field), intent(in) :: field
    real(dp), intent(out), contiguous :: numbers(:)       !! (field%length)
    logical, intent(out), optional :: lost                !! there are NaN or infinity
    integer :: n
    n = 0
    if (result%mode_count > 0 .or. allocated(result%record) .or. field%is_integer) &
      n = min(value_count(result, field%along), size(numbers))
    if (n > 0) then
      if (associated(field%from_case)) then
        call field%from_case(result, numbers(:n))
      else if (field%along == along_modes) then
        call field%from_modes(result%modes, result%units, numbers(:n))
      else
        call field%from_modes(result%before, result%units, numbers(:n))
      end if
    end if
    numbers(n + 1:) = missing
    if (field%is_integer) numbers(n + 1:) = 0.0_dp
    if (present(lost)) lost = .not. all(ieee_is_finite(numbers(:n)))
    where (.not. ieee_is_finite(numbers(:n))) numbers(:n) = missing
  end subroutine put_field

  pure integer function value_count(result, along) result(n)
    !! How many values a case has along a dimension; no limit where that is the same for all cases.
    type(case_result), intent(in) :: result
    integer, intent(in) :: along               !! place among `dimension_names`
    select case (along)
    case (no_dimension); n = huge(n)
    case (along_modes); n = result%modes%count
    case (along_modes_before); n = result%before%count
    case (along_events); n = size(result%events)
    case (along_peaks); n = size(result%measured%angular_frequency)
    case default; n = huge(n)
    end select
  end function value_count

  pure function named_value(result, name) result(values)
    !! The values of a variable by its name in SI units, (its dimension) or (1); all of them fill where no modes were found.
    !! **Limits**: a variable of the scene's result that is a scalar or over modes, events or peaks.
    type(case_result), intent(in) :: result
    character(*), intent(in) :: name
    real(dp), allocatable :: values(:)
    type(result_variable), allocatable :: rows(:)
    type(case_field) :: field
    integer :: n
    rows = some_variables(allocated(result%record))
    field%result_variable = rows(findloc(rows%name == name, .true., dim=1))
    field%along = findloc(dimension_names == field%dimensions, .true., dim=1)
    n = 1
    if (field%dimensions /= '') n = value_count(result, field%along)
    allocate (values(n))
    call put_field(result, field, values)
  end function named_value

  pure function blocks_for(fields, cases) result(blocks)
    !! Two empty blocks: of the short fields, and of the long ones.
    type(case_field), intent(in) :: fields(:)             !! all of a case
    integer, intent(in) :: cases                          !! of the sweep
    type(case_block) :: blocks(2)
    integer :: short
    short = count(.not. is_long(fields))
    blocks(1) = block_for(fields(:short), 0, min(int(cases, i8), block_numbers/case_length(fields(:short))))
    blocks(2) = block_for(fields(short + 1:), short, min(int(cases, i8), long_numbers/max(1_i8, case_length(fields(short + 1:)))))
  end function blocks_for

  pure type(case_block) function block_for(fields, before, capacity) result(block)
    !! An empty block with room for so many cases, one at least.
    type(case_field), intent(in) :: fields(:)
    integer, intent(in) :: before                         !! how many fields of a case stand before these
    integer(i8), intent(in) :: capacity
    allocate (block%fields, source=fields)
    block%before = before
    block%capacity = int(max(1_i8, capacity))
  end function block_for

  pure logical function takes(self, case)
    !! Whether there is room for a case, and it follows those that are there.
    class(case_block), intent(in) :: self
    integer(i8), intent(in) :: case
    takes = self%count == 0 .or. (self%count < self%capacity .and. case == self%first + self%count)
  end function takes

  pure subroutine add_case(self, case, numbers)
    !! Add a case that the block takes.
    class(case_block), intent(inout) :: self
    integer(i8), intent(in) :: case
    real(dp), intent(in), contiguous :: numbers(:)        !! of all its fields
    integer(i8) :: first
    integer :: i
    if (.not. allocated(self%numbers)) allocate (self%numbers(case_length(self%fields)*self%capacity))
    if (self%count == 0) self%first = case
    do i = 1, size(self%fields)
      associate (field => self%fields(i))
        first = self%begin_of(field) + self%count*field%length
        self%numbers(first:first + field%length - 1) = numbers(field%first:field%first + field%length - 1)
      end associate
    end do
    self%count = self%count + 1
  end subroutine add_case

  pure integer(i8) function begin_of(self, field)
    !! Where the numbers of one of its fields begin, those of the first case.
    class(case_block), intent(in) :: self
    type(case_field), intent(in) :: field
    begin_of = (field%first - self%fields(1)%first)*self%capacity + 1
  end function begin_of

end module bw_case_fields
