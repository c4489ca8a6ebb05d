module bw_result_table
  !! The table of a file's variables. Each variable is one row: a call that gives its name, dimensions, unit and meaning
  !! and returns whether its values are wanted now, followed by its values:
  !!
  !!     if (table%real_row('impulse', '', 'N s', 'impulse of the impact on the beam')) call table%put([impulse])
  !!
  !! The rows are walked through repeatedly: first to define the variables, which gives each its place in the file, then
  !! to put values into these places, or to find those of one name.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_classic_file, only: classic_file
  use bw_classic_head, only: letters, most_bytes, reals, wholes
  use bw_kinds, only: dp, i4, i8
  use bw_missing, only: missing
  use bw_result_layout, only: has, result_layout
  use bw_text, only: fitted, joined, string
  implicit none (type, external)
  private

  character(*), parameter, public :: unit_of_sensors = 'of the sensors'
    !! stands for the unit of the measured quantity, given by a record's sensors; m for simulated histories
  integer, parameter, public :: before_cases = 1, of_cases = 2, of_case_ends = 3, after_cases = 4, of_supplement = 5, of_notes = 6
    !! sections of rows, in their order: values known before any case is run; numbers that depend on the case; statuses
    !! of cases, which are put after these are on the disk; values known when all cases are done; supplements; texts of
    !! cases, for which the disk reserves no room, as few have them
  integer, parameter :: defining = 1, putting = 2, naming = 3         !! purposes of a walk
  integer, parameter, public :: most_waiting = 2**18 !! numbers of cases in memory; a larger case is put at once; tuned

  type, public :: summary_row
    !! A variable whose quantiles over the cases of a design are requested.
    character(:), allocatable :: name, dimensions, units, long_name    !! without `case`
  end type summary_row

  type, extends(classic_file), public :: result_table
    type(result_layout) :: layout            !! of the result; the default for any other file
    type(summary_row), allocatable :: summaries(:)   !! of a design, in the order of the rows; else empty
    character(:), allocatable :: swept       !! variables of swept inputs, separated by spaces
    integer(i8) :: case_numbers = 0          !! numbers per case
    real(dp), allocatable :: found(:)        !! the values of the requested name
    character(:), allocatable :: lost        !! names of variables with NaN or infinity in the present case, which no stage should
                                             !! leave, each after ', '; they are filled
    integer, private :: walk = defining, section = before_cases
    integer, private :: before(before_cases:of_notes + 1) = 0   !! rows before each section
    character(:), allocatable, private :: row_names         !! of all rows, concatenated
    integer, allocatable, private :: row_ends(:)            !! (0 to rows) ends of their names
    integer, allocatable, private :: row_variables(:)       !! (rows) index of a row's variable; 0: not in the file
    integer, private :: row_at = 0                          !! the last row visited
    integer(i8), allocatable, private :: numbers_before(:)  !! (variables) offset in the numbers of a case; −1: not among them
    integer, private :: at = 0               !! the present variable
    logical, private :: is_blank = .false.   !! the present case has no reals
    integer(i8), private :: case = 1         !! the present case
    character(:), allocatable, private :: suffix, ending, wanted
    real(dp), allocatable, private :: waiting(:, :)     !! (case_numbers, cases) numbers of cases not written yet
    integer(i8), allocatable, private :: waiting_cases(:)
    integer, private :: waiting_count = 0
  contains
    procedure :: begin_section, begin_case, begin_names, look_for
    procedure :: real_row, whole_row, text_row
    procedure :: lay_out
    procedure, private :: put_list, put_wholes
    generic :: put => put_list, put_wholes
    procedure :: put_columns, put_texts, put_again, store, write_cases, is_gathered
    procedure, private :: row, find_row, sum_up, define, fill, wanted_count
  end type result_table

contains

  subroutine begin_section(self, section)
    !! Begin the rows of a section.
    class(result_table), intent(inout) :: self
    integer, intent(in) :: section
    if (.not. allocated(self%row_names)) then
      self%row_names = ''
      self%row_ends = [0]
      allocate (self%summaries(0))
      allocate (self%row_variables(0))
    end if
    if (self%walk == defining) self%before(section:) = size(self%row_variables)
    self%section = section
    self%row_at = self%before(section)
    self%is_blank = .false.
    self%case = 1
    call self%begin_names('', '')
  end subroutine begin_section

  subroutine begin_case(self, case, is_blank)
    !! Begin the rows of a case.
    class(result_table), intent(inout) :: self
    integer(i8), intent(in) :: case          !! its number, from 1
    logical, intent(in) :: is_blank          !! none of its reals exists; its integers do
    call self%begin_section(of_cases)
    self%is_blank = is_blank
    self%case = case
    self%lost = ''
    if (self%case_numbers > most_waiting) return
    if (.not. allocated(self%waiting)) then
      associate (most => max(1_i8, min(most_waiting/max(1_i8, self%case_numbers), int(self%layout%cases, i8))))
        allocate (self%waiting(self%case_numbers, most), self%waiting_cases(most))
      end associate
    end if
    if (self%waiting_count == size(self%waiting_cases)) call self%write_cases()
    self%waiting_count = self%waiting_count + 1
    self%waiting_cases(self%waiting_count) = case
  end subroutine begin_case

  subroutine begin_names(self, suffix, ending)
    !! Append a suffix to the names of the rows that follow, and an ending to their meanings.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: suffix, ending
    self%suffix = suffix
    self%ending = ending
  end subroutine begin_names

  subroutine look_for(self, name)
    !! Let the rows that follow put the values of one name into `found`, whether or not a file has it.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name
    self%walk = naming
    self%wanted = name
    call self%begin_names('', '')
  end subroutine look_for

  logical function real_row(self, name, dimensions, units, long_name, references, needs, is_complete, summary) result(wanted)
    !! Define or request the row of reals.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: dimensions                     !! names in the file's order, separated by spaces; empty for a scalar
    character(*), intent(in) :: units                          !! UDUNITS
    character(*), intent(in) :: long_name
    character(*), intent(in), optional :: references           !! the paper's equation; absent or empty: none
    character(*), intent(in), optional :: needs                !! further condition on the result, for `has`
    logical, intent(in), optional :: is_complete               !! every value exists, as for coordinates; absent: some may not
    logical, intent(in), optional :: summary                   !! a design has quantiles over its cases; absent: not
    logical :: is_filled
    wanted = self%row(name, reals, dimensions, units, long_name, needs)
    if (wanted .and. self%is_blank) call self%fill(0_i8)
    wanted = wanted .and. .not. self%is_blank
    if (self%walk /= defining .or. self%at == 0) return
    if (present(summary)) call self%sum_up(name, dimensions, units, long_name, summary)
    is_filled = .true.
    if (present(is_complete)) is_filled = .not. is_complete
    if (is_filled) call self%head%add_fill()
    if (.not. present(references)) return
    if (references /= '') call self%head%add_text('references', trim(references))
  end function real_row

  subroutine sum_up(self, name, dimensions, units, long_name, wanted)
    !! Store what the quantile rows of a design need of a variable.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name, dimensions, units, long_name
    logical, intent(in) :: wanted
    type(summary_row), allocatable :: more(:)
    integer :: i, n
    if (.not. wanted .or. self%layout%quantiles == 0) return
    n = size(self%summaries)
    allocate (more(n + 1))
    do i = 1, n
      more(i) = self%summaries(i)
    end do
    more(n + 1)%name = name
    more(n + 1)%dimensions = dimensions
    more(n + 1)%units = units
    more(n + 1)%long_name = long_name
    call move_alloc(more, self%summaries)
  end subroutine sum_up

  logical function whole_row(self, name, dimensions, long_name, flags, first_flag, has_masks, needs) result(wanted)
    !! Define or request the row of integers, 0 by default. xarray would read integers with a fill value as reals.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name, dimensions, long_name
    character(*), intent(in), optional :: flags(:)             !! CF flags: the meanings of the numbers
    integer, intent(in), optional :: first_flag                !! the number of the first; absent: 0
    logical, intent(in), optional :: has_masks                 !! they are bits 1, 2, 4, …, which may be combined
    character(*), intent(in), optional :: needs
    integer :: first, i
    wanted = self%row(name, wholes, dimensions, '1', long_name, needs)
    if (self%walk /= defining .or. self%at == 0 .or. .not. present(flags)) return
    first = 0
    if (present(first_flag)) first = first_flag
    if (present(has_masks)) then
      call self%head%add_wholes('flag_masks', [(2_i4**(i - 1), i=1, size(flags))])
    else
      call self%head%add_wholes('flag_values', [(int(first + i - 1, i4), i=1, size(flags))])
    end if
    call self%head%add_text('flag_meanings', joined(flags))
  end function whole_row

  logical function text_row(self, name, dimensions, long_name, needs) result(wanted)
    !! Define or request the row of texts; their letters are the last dimension.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name, dimensions, long_name
    character(*), intent(in), optional :: needs
    wanted = self%row(name, letters, dimensions, '1', long_name, needs)
    if (self%walk == defining .and. self%at > 0) call self%head%add_text('_Encoding', 'utf-8')
  end function text_row

  logical function row(self, name, kind, dimensions, units, long_name, needs) result(wanted)
    !! Go to the next row.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name, dimensions, units, long_name
    integer, intent(in) :: kind
    character(*), intent(in), optional :: needs
    wanted = .false.
    select case (self%walk)
    case (defining)
      call self%define(name, kind, dimensions, units, long_name, needs)
    case (putting)
      call self%find_row(name)
      wanted = self%at > 0
    case default
      wanted = name//self%suffix == self%wanted
    end select
  end function row

  pure subroutine find_row(self, name)
    !! Go to the variable of a row of the present section; 0 if the file lacks it. The row after the last one is tried first.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name
    integer :: r, i, n
    n = self%before(self%section + 1) - self%before(self%section)
    self%at = 0
    do i = 0, n - 1
      r = self%before(self%section) + 1 + modulo(self%row_at - self%before(self%section) + i, n)
      associate (there => self%row_names(self%row_ends(r) + 1:self%row_ends(r + 1)), first => len(name))
        if (len(there) /= first + len(self%suffix)) cycle
        if (there(:first) /= name .or. there(first + 1:) /= self%suffix) cycle
      end associate
      self%row_at = r
      self%at = self%row_variables(r)
      return
    end do
  end subroutine find_row

  subroutine define(self, name, kind, dimensions, units, long_name, needs)
    !! Define the variable of a row, if the file has all of its dimensions and meets the row's condition.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name, dimensions, units, long_name
    integer, intent(in) :: kind
    character(*), intent(in), optional :: needs
    character(:), allocatable :: all_dimensions, unit, coordinates
    integer, allocatable :: numbers(:)
    logical :: has_case, is_there
    has_case = any(self%section == [of_cases, of_case_ends, of_notes])
    all_dimensions = dimensions
    if (has_case .and. self%layout%cases > 0) all_dimensions = 'case '//dimensions
    numbers = self%head%dimensions_of(all_dimensions)
    is_there = all(numbers > 0)
    if (is_there .and. present(needs)) is_there = has(self%layout, needs)
    self%at = 0
    self%row_names = self%row_names//name//self%suffix
    self%row_ends = [self%row_ends, len(self%row_names)]
    self%row_variables = [self%row_variables, merge(self%head%count + 1, 0, is_there)]
    if (is_there) then
      call self%head%add_variable(name//self%suffix, kind, numbers, merge(max(1, self%layout%cases), 1, has_case))
      self%at = self%head%count
      unit = units
      if (index(units, unit_of_sensors) == 1) then
        unit = 'm'
        if (allocated(self%layout%record)) unit = self%layout%record%unit
        unit = unit//units(len(unit_of_sensors) + 1:)
      end if
      call self%head%add_text('units', unit)
      call self%head%add_text('long_name', long_name//self%ending)
      coordinates = ''
      if (has_case) coordinates = trim(adjustl(self%swept//positions_of(self%layout, dimensions)))
      if (coordinates /= '') call self%head%add_text('coordinates', coordinates)
    end if
  end subroutine define

  pure function positions_of(layout, dimensions) result(name)
    !! Name the coordinate along the beam that belongs to dimensions, after a space.
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: dimensions
    character(:), allocatable :: name
    name = ''
    if (index(dimensions, 'point') == 1 .and. has(layout, 'places')) name = ' point_position'
    if (index(' '//dimensions, ' profile') > 0) name = ' profile_position'
  end function positions_of

  subroutine lay_out(self, head, fits)
    !! End the definitions, and give the variables their places. From now on values are put.
    class(result_table), intent(inout) :: self
    character(:), allocatable, intent(out) :: head        !! the first bytes of the file
    logical, intent(out) :: fits                          !! .false.: a variable needs a head with wider sizes
    integer :: r, v
    self%before(self%section + 1:) = size(self%row_variables)
    associate (variables => self%head%variables(:self%head%count))
      fits = self%head%width == 8 .or. all(variables%count*variables%width <= most_bytes)
    end associate
    if (.not. fits) return
    call self%head%lay_out(head)
    allocate (self%numbers_before(self%head%count), source=-1_i8)
    do r = self%before(of_cases) + 1, self%before(of_case_ends)
      v = self%row_variables(r)
      if (v == 0) cycle
      self%numbers_before(v) = self%case_numbers
      self%case_numbers = self%case_numbers + self%head%variables(v)%room
    end do
    self%walk = putting
  end subroutine lay_out

  pure integer(i8) function wanted_count(self) result(count)
    !! Return the number of values that are wanted.
    class(result_table), intent(in) :: self
    count = huge(count)
    if (self%walk == putting) count = self%head%variables(self%at)%room
  end function wanted_count

  recursive subroutine store(self, first, values)
    !! Put some of the numbers of the present row; those of a case are buffered, unless they are many.
    class(result_table), intent(inout) :: self
    integer(i8), intent(in) :: first         !! offset in the row
    real(dp), intent(in), contiguous :: values(:)
    real(dp), allocatable :: sound(:)
    character(:), allocatable :: name
    if (self%walk == naming) then
      self%found = merge(values, missing, ieee_is_finite(values))
    else if (self%section == of_cases .and. .not. all(ieee_is_finite(values))) then
      name = self%head%variables(self%at)%name
      if (index(self%lost//',', ' '//name//',') == 0) self%lost = self%lost//', '//name
      sound = merge(values, missing, ieee_is_finite(values))
      call self%store(first, sound)
    else if (self%section == of_cases .and. self%waiting_count > 0) then
      associate (before => self%numbers_before(self%at) + first)
        self%waiting(before + 1:before + size(values), self%waiting_count) = values
      end associate
    else
      associate (width => self%head%variables(self%at)%width)
        call self%file%put_numbers(self%place_of(self%at, self%case) + first*width, width, values)
      end associate
    end if
  end subroutine store

  subroutine fill(self, first, last)
    !! Put fill from an offset on.
    class(result_table), intent(inout) :: self
    integer(i8), intent(in) :: first         !! offset in the row
    integer(i8), intent(in), optional :: last    !! absent: to the end of the row
    real(dp) :: none(256)
    integer(i8) :: i, end
    end = self%wanted_count()
    if (present(last)) end = last
    if (self%walk == naming .or. first >= end) return
    none = merge(missing, 0.0_dp, self%head%variables(self%at)%kind == reals)
    do i = first, end - 1, size(none)
      call self%store(i, none(:min(size(none, kind=i8), end - i)))
    end do
  end subroutine fill

  subroutine put_list(self, values)
    !! Put the numbers of a row, the last dimension fastest; missing ones at the end are filled.
    class(result_table), intent(inout) :: self
    real(dp), intent(in), optional, contiguous :: values(:)     !! absent: none
    integer(i8) :: n
    n = 0
    if (present(values)) n = min(size(values, kind=i8), self%wanted_count())
    if (present(values)) call self%store(0_i8, values(:n))
    call self%fill(n)
  end subroutine put_list

  subroutine put_wholes(self, values)
    !! Put integers.
    class(result_table), intent(inout) :: self
    integer, intent(in) :: values(:)
    call self%put_list(real(values, dp))
  end subroutine put_wholes

  subroutine put_columns(self, columns)
    !! Put the numbers of a row of two dimensions: each column runs along the last one.
    class(result_table), intent(inout) :: self
    real(dp), intent(in), optional, contiguous :: columns(:, :)  !! absent: none
    integer(i8) :: length, c, n
    if (.not. present(columns)) then
      call self%fill(0_i8)
      return
    end if
    length = last_length(self)
    n = min(size(columns, 1, kind=i8), length)
    do c = 1, min(size(columns, 2, kind=i8), self%wanted_count()/length)
      call self%store((c - 1)*length, columns(:n, c))
      call self%fill((c - 1)*length + n, c*length)
    end do
    call self%fill((c - 1)*length)
  end subroutine put_columns

  pure integer function last_length(self) result(length)
    !! Return the length of the last dimension of the present row.
    class(result_table), intent(in) :: self
    associate (dimensions => self%head%variables(self%at)%dimensions)
      length = self%head%lengths(dimensions(size(dimensions)))
    end associate
  end function last_length

  subroutine put_texts(self, texts)
    !! Put texts, each cut to its room, or padded with zeros.
    class(result_table), intent(inout) :: self
    type(string), intent(in) :: texts(:)
    integer :: length, i
    length = last_length(self)
    do i = 1, size(texts)
      call self%file%put_text(self%place_of(self%at, self%case) + (i - 1)*length, fitted(texts(i)%text, length))
    end do
  end subroutine put_texts

  subroutine put_again(self, name, values)
    !! Replace the values of a variable of the present case.
    class(result_table), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: values(:)
    self%at = self%variable(name)
    if (self%at > 0) call self%put(values)
  end subroutine put_again

  subroutine write_cases(self)
    !! Pass all buffered numbers to the system.
    class(result_table), intent(inout) :: self
    integer :: v, i
    call self%file%hold()
    do v = 1, merge(self%head%count, 0, self%waiting_count > 0)
      if (self%numbers_before(v) < 0) cycle
      associate (before => self%numbers_before(v), room => self%head%variables(v)%room)
        do i = 1, self%waiting_count
          call self%file%put_numbers(self%place_of(v, self%waiting_cases(i)), self%head%variables(v)%width, &
                                     self%waiting(before + 1:before + room, i))
        end do
      end associate
    end do
    call self%file%write()
    self%waiting_count = 0
  end subroutine write_cases

  pure logical function is_gathered(self, variable)
    !! Return whether the numbers of a variable are among those of a case.
    class(result_table), intent(in) :: self
    integer, intent(in) :: variable
    is_gathered = self%numbers_before(variable) >= 0
  end function is_gathered

end module bw_result_table
