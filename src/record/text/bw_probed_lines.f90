module bw_probed_lines
  !! The first lines of a text split at one separator: which fields are numbers, how many a row has, and which lines are
  !! rows.
  use bw_text, only: string
  use bw_text_fields, only: fields_of, is_missing_word, number_marks
  use bw_text_header, only: is_comment
  implicit none (type, external)
  private
  public :: any_number, is_row, number_columns, numbers_in, probe, usual_count

  type, public :: probed_line
    !! A line split at one separator.
    type(string), allocatable :: fields(:)
    logical, allocatable :: numeric(:)                         !! fields that are numbers
  end type probed_line

contains

  subroutine probe(line, separator, probed)
    !! Split a line and find which fields are numbers; a comment has no fields.
    character(*), intent(in) :: line
    character, intent(in) :: separator
    type(probed_line), intent(out) :: probed
    character(:), allocatable :: marks
    integer :: i
    if (is_comment(line)) then
      allocate (probed%fields(0), probed%numeric(0))
      return
    end if
    probed%fields = fields_of(line, separator)
    allocate (probed%numeric(size(probed%fields)))
    do i = 1, size(probed%fields)
      marks = number_marks(probed%fields(i)%text)
      probed%numeric(i) = marks /= ''
    end do
  end subroutine probe

  pure integer function usual_count(probed) result(columns)
    !! Return how many fields most lines with numbers have; of equally frequent counts, the one that occurs last.
    type(probed_line), intent(in) :: probed(:)
    integer :: fields(size(probed))                            ! of lines with numbers; 0 for others
    integer :: n, lines, most
    fields = 0
    do n = 1, size(probed)
      if (any(probed(n)%numeric)) fields(n) = size(probed(n)%fields)
    end do
    columns = 0
    most = 0
    do n = size(probed), 1, -1
      if (fields(n) == 0 .or. fields(n) == columns) cycle
      lines = count(fields == fields(n))
      if (lines <= most) cycle
      most = lines
      columns = fields(n)
    end do
  end function usual_count

  pure function number_columns(probed, columns) result(numeric)
    !! Return which columns hold numbers in more than half of the lines with this many fields.
    type(probed_line), intent(in) :: probed(:)
    integer, intent(in) :: columns
    logical :: numeric(columns)
    integer :: found(columns), n
    found = 0
    do n = 1, size(probed)
      if (size(probed(n)%fields) == columns .and. any(probed(n)%numeric)) found = found + merge(1, 0, probed(n)%numeric)
    end do
    numeric = 2*found > maxval(found)
  end function number_columns

  pure logical function any_number(probed, columns)
    !! Return whether the last of this many fields is a number in some line.
    type(probed_line), intent(in) :: probed(:)
    integer, intent(in) :: columns
    integer :: n
    any_number = .false.
    do n = 1, size(probed)
      if (size(probed(n)%fields) == columns) any_number = any_number .or. probed(n)%numeric(columns)
    end do
  end function any_number

  pure integer function numbers_in(probed, numeric) result(numbers)
    !! Count the numbers in rows; if there are no rows, in lines with as many fields.
    type(probed_line), intent(in) :: probed(:)
    logical, intent(in) :: numeric(:)                          !! columns of numbers
    integer :: n, others
    numbers = 0
    others = 0
    do n = 1, size(probed)
      if (size(probed(n)%fields) /= size(numeric)) cycle
      others = others + count(probed(n)%numeric)
      if (is_row(probed(n), numeric)) numbers = numbers + count(probed(n)%numeric)
    end do
    if (numbers == 0) numbers = others
  end function numbers_in

  pure logical function is_row(line, numeric)
    !! Return whether a line has numbers, or marks of missing ones, in all columns of numbers.
    type(probed_line), intent(in) :: line
    logical, intent(in) :: numeric(:)                          !! columns of numbers
    integer :: i
    logical :: says_something                                  !! a number or a word like `nan`, not only dashes
    is_row = size(line%fields) == size(numeric)
    if (.not. is_row) return
    says_something = any(line%numeric .and. numeric)
    do i = 1, size(numeric)
      if (line%numeric(i) .or. .not. numeric(i)) cycle
      is_row = is_row .and. is_missing_word(line%fields(i)%text)
      says_something = says_something .or. scan(line%fields(i)%text, 'naNAiI') > 0
    end do
    is_row = is_row .and. says_something
  end function is_row

end module bw_probed_lines
