module bw_text_source
  !! A text file as a source of histories. It is read twice from front to back, once for the times and once for the columns
  !! used, so that only numbers are kept in memory.
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: dp, i1, i8
  use bw_line_reader, only: line_reader, text_between
  use bw_missing, only: missing
  use bw_record_source, only: record_source
  use bw_table_row, only: row_form, says_nothing, scan_row
  use bw_text, only: append, string, text_of
  use bw_text_header, only: is_comment
  use bw_text_layout, only: find_layout, most_probed, text_layout
  use bw_text_rows, only: judge_row, prepared
  implicit none (type, external)
  private

  integer, parameter :: most_bytes = 2**20                 !! of the lines that show the layout; the first three may be longer

  type, extends(record_source), public :: text_source
    type(text_layout) :: layout
    type(line_reader), private :: reader
  contains
    procedure :: open => open_text
    procedure :: read_times
    procedure :: read_values
    procedure :: place_of_row
    procedure :: close => close_text
    procedure, private :: rewind => rewind_text
    procedure, private :: next_row
    procedure, private :: take_gaps
  end type text_source

contains

  subroutine open_text(self, path, error)
    !! Find the layout from the first lines.
    class(text_source), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: lines(:)
    character(:), allocatable :: line
    logical :: there
    integer :: rows, bytes
    self%path = path
    call self%reader%open(path, error)
    if (allocated(error)) return
    call refuse_binary(self%reader%bytes(:self%reader%have), path, error)
    allocate (lines(0))
    rows = 0
    bytes = 0
    do while (rows < most_probed .and. size(lines) < 10*most_probed .and. (size(lines) < 3 .or. bytes < most_bytes))
      call self%reader%next_line(there, error)
      if (allocated(error)) return
      if (.not. there) exit
      line = text_between(self%reader%bytes, self%reader%first, self%reader%last)
      call append(lines, line)
      if (.not. is_comment(line)) rows = rows + 1
      bytes = bytes + len(line)
      if (index(line, achar(13)) > 0) call fail(error, status_bad_file, path//':'//text_of(size(lines))// &
        ': the line contains a carriage return; accepted: lines that end with LF or CR LF')
      if (allocated(error)) return
    end do
    call find_layout(path, lines, self%layout, error)
    if (.not. allocated(error)) self%columns = self%layout%columns
  end subroutine open_text

  pure subroutine refuse_binary(bytes, path, error)
    !! Report what a file that is not a table of text may be. **Errors**: `status_bad_file`.
    integer(i1), intent(in) :: bytes(:)                    !! from the beginning of the file
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    character(*), parameter :: makes = '; accepted: text or NetCDF, to which beamwave-record converts UFF 58, LabVIEW, '// &
                               'MATLAB, NumPy, WAV and other files'
    character(:), allocatable :: head, problem
    integer :: line
    head = text_between(bytes, 1, min(size(bytes), 40))
    problem = ''
    if (index(head, char(255)//char(254)) == 1 .or. index(head, char(254)//char(255)) == 1) then
      problem = 'is text in UTF-16; accepted: UTF-8, as "CSV UTF-8" of spreadsheets'
    else if (index(head, char(31)//char(139)) == 1 .or. index(head, 'PK') == 1) then
      problem = 'is compressed, or a spreadsheet'//makes
    else if (index(head, 'MATLAB') == 1 .or. index(head, 'RIFF') == 1 .or. any(bytes == 0)) then
      problem = 'is binary'//makes
    else if (index(head, 'LabVIEW Measurement') == 1) then
      problem = 'is a LabVIEW measurement'//makes
    else if (index(head, '    -1') == 1) then
      line = index(head, new_line('a')) + 1
      if (line > 7 .and. verify(head(line:min(len(head), line + 5)), ' 0123456789') == 0) problem = &
        'is a universal file (UFF)'//makes
    end if
    if (problem /= '') call fail(error, status_bad_file, path//': '//problem)
  end subroutine refuse_binary

  subroutine rewind_text(self, error)
    !! Go back to the first row.
    class(text_source), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    logical :: there
    integer :: i
    call self%reader%open(self%path, error)
    do i = 1, self%layout%header
      if (allocated(error)) return
      call self%reader%next_line(there, error)
    end do
  end subroutine rewind_text

  subroutine next_row(self, there, error)
    !! Go to the next line that is not empty and no comment.
    class(text_source), intent(inout) :: self
    logical, intent(out) :: there
    type(error_type), allocatable, intent(inout) :: error
    do
      call self%reader%next_line(there, error)
      if (.not. there) return
      if (.not. says_nothing(self%reader%bytes, self%reader%first, self%reader%last)) return
    end do
  end subroutine next_row

  subroutine read_times(self, column, rows, times, steps, error)
    !! Read the times in one pass over the file.
    class(text_source), intent(inout) :: self
    integer, intent(in) :: column
    integer(i8), intent(out) :: rows
    real(dp), allocatable, intent(out) :: times(:), steps(:)
    type(error_type), allocatable, intent(inout) :: error
    type(row_form) :: form
    real(dp) :: number(1)
    integer :: decade(1)
    logical :: there, good
    rows = 0
    allocate (times(merge(4096, 0, column > 0)), steps(merge(4096, 0, column > 0)))
    form = prepared(self%layout, pack([column], [column > 0]))
    call self%rewind(error)
    do while (.not. allocated(error))
      call self%next_row(there, error)
      if (.not. there) exit
      rows = rows + 1
      if (column == 0) cycle
      call scan_row(form, self%reader%bytes, self%reader%first, self%reader%last, number, decade, good)
      if (.not. good) call self%take_gaps([column], number, error)
      if (rows > size(times)) call grow(self%path, times, error)
      if (rows > size(steps)) call grow(self%path, steps, error)
      if (allocated(error)) return
      times(rows) = number(1)
      steps(rows) = 10.0_dp**max(-300, min(300, decade(1)))
    end do
    if (column == 0) return
    times = times(:rows)
    steps = steps(:rows)
  end subroutine read_times

  pure subroutine grow(path, numbers, error)
    !! Double the capacity. **Errors**: `status_bad_file` if memory is refused.
    character(*), intent(in) :: path
    real(dp), allocatable, intent(inout) :: numbers(:)
    type(error_type), allocatable, intent(inout) :: error
    real(dp), allocatable :: more(:)
    integer :: status
    allocate (more(2*size(numbers)), stat=status)
    if (status /= 0) call fail(error, status_bad_file, path//': not enough memory')
    if (allocated(error)) return
    more(:size(numbers)) = numbers
    call move_alloc(more, numbers)
  end subroutine grow

  subroutine read_values(self, columns, first, values, error)
    !! Read the values in another pass, up to the last row requested.
    class(text_source), intent(inout) :: self
    integer, intent(in) :: columns(:)
    integer(i8), intent(in) :: first
    real(dp), intent(inout), contiguous :: values(:, :)
    type(error_type), allocatable, intent(inout) :: error
    type(row_form) :: form
    real(dp) :: numbers(size(columns))
    integer :: decades(size(columns))
    integer(i8) :: row, i
    logical :: there, good
    form = prepared(self%layout, columns)
    call self%rewind(error)
    do row = 1, first + size(values, 1) - 1
      if (allocated(error)) return
      call self%next_row(there, error)
      if (.not. there) call fail(error, status_bad_file, self%path//': became shorter while it was read')
      if (row < first .or. .not. there) cycle
      call scan_row(form, self%reader%bytes, self%reader%first, self%reader%last, numbers, decades, good)
      if (.not. good) call self%take_gaps(columns, numbers, error)
      i = row - first + 1
      values(i, :) = numbers
    end do
  end subroutine read_values

  subroutine take_gaps(self, columns, numbers, error)
    !! Read the other numbers of a row that could not be read: it lacks some, or is invalid. **Errors**: `status_bad_file`
    !! if it is invalid.
    class(text_source), intent(in) :: self
    integer, intent(in) :: columns(:)                      !! requested columns
    real(dp), intent(out) :: numbers(:)                    !! `missing` where absent
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: problem
    logical :: lacks(size(columns)), good
    real(dp) :: own(size(columns))
    integer :: decades(size(columns)), n
    call judge_row(self%layout, columns, text_between(self%reader%bytes, self%reader%first, self%reader%last), lacks, problem)
    if (problem /= '') call fail(error, status_bad_file, self%path//':'//text_of(self%reader%line)//': '//problem)
    n = count(.not. lacks)
    call scan_row(prepared(self%layout, pack(columns, .not. lacks)), self%reader%bytes, self%reader%first, self%reader%last, &
      own(:n), decades(:n), good)
    numbers = missing
    if (good) numbers = unpack(own(:n), .not. lacks, missing)
  end subroutine take_gaps

  function place_of_row(self, row) result(place)
    !! Return the line of a row, for a message, found in one more pass.
    class(text_source), intent(inout) :: self
    integer(i8), intent(in) :: row
    character(:), allocatable :: place
    type(error_type), allocatable :: error
    logical :: there
    integer(i8) :: i
    place = self%path
    call self%rewind(error)
    do i = 1, row
      if (.not. allocated(error)) call self%next_row(there, error)
      if (allocated(error)) return
    end do
    place = place//':'//text_of(self%reader%line)
  end function place_of_row

  subroutine close_text(self)
    !! Close the file.
    class(text_source), intent(inout) :: self
    call self%reader%close()
  end subroutine close_text

end module bw_text_source
