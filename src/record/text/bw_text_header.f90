module bw_text_header
  !! Reads the lines before the rows of a table: the names of its columns, and their units.
  use bw_record, only: bare_name, column_type, unit_in
  use bw_sensor_unit, only: is_unit, quantity_of
  use bw_text, only: lower, string
  use bw_text_fields, only: blanks, fields_of, tab
  use bw_time_column, only: mark_time
  implicit none (type, external)
  private
  public :: is_comment, name_columns

contains

  pure logical function is_comment(line)
    !! Return whether the line is empty or a comment.
    character(*), intent(in) :: line
    integer :: first
    first = verify(line, ' '//tab)
    is_comment = first == 0
    if (first > 0) is_comment = line(first:first) == '#' .or. line(first:first) == '%'
  end function is_comment

  subroutine name_columns(lines, separator, closed, columns)
    !! Find the names: in the last line of the header with one field for each column, or in the line before if that holds
    !! units; in a comment if no other line has them. Their separator may be another one than that of the rows.
    type(string), intent(in) :: lines(:)                       !! of the header
    character, intent(in) :: separator
    logical, intent(in) :: closed                              !! one more column is empty in all rows
    type(column_type), intent(inout) :: columns(:)
    character(*), parameter :: marks = tab//';,'               !! names between these may stand above rows parted by others
    type(string), allocatable :: names(:), units(:)
    character(:), allocatable :: tried
    integer :: i
    allocate (names(0), units(0))
    tried = separator//marks
    do i = 1, len(tried)
      call find_names(lines, .false., tried(i:i), closed, size(columns), names, units)
      if (size(names) == 0) call find_names(lines, .true., tried(i:i), closed, size(columns), names, units)
      if (size(names) + size(units) > 0) exit
    end do
    do i = 1, size(columns)
      associate (column => columns(i))
        if (size(names) > 0) column%name = names(i)%text
        column%unit = unit_in(column%name)
        if (size(units) > 0) column%unit = plain_unit(units(i)%text)
        column%quantity = quantity_of(column%unit)
        call mark_time(column)
      end associate
    end do
  end subroutine name_columns

  pure subroutine find_names(lines, comments, separator, closed, columns, names, units)
    !! Find the last line that can hold names, and the units below it. Away from the rows, `Rate,1000` is not accepted as names;
    !! a line of numbers is only if there is no other.
    type(string), intent(in) :: lines(:)
    logical, intent(in) :: comments                            !! search comments, else other lines
    character, intent(in) :: separator
    logical, intent(in) :: closed
    integer, intent(in) :: columns                             !! number of columns
    type(string), allocatable, intent(inout) :: names(:), units(:)
    type(string), allocatable :: fields(:), above(:)
    logical :: is_near                                         !! only units are between the line and the rows
    integer :: n
    is_near = .true.
    n = size(lines) + 1
    call next_above(lines, comments, separator, columns, n, fields)
    do while (size(fields) > 0)
      call next_above(lines, comments, separator, columns, n, above)
      if (fits(fields, closed, columns)) then
        if (size(units) == 0 .and. are_units(fields(:columns), above, closed, columns)) then
          units = fields(:columns)
          is_near = .true.
        else if (are_words(fields(:columns)) .or. (is_near .and. count_words(fields(:columns)) > 0)) then
          names = fields(:columns)
          return
        else
          if (is_near) names = fields(:columns)
          is_near = .false.
        end if
      else if (size(fields) > 0) then
        is_near = .false.
      end if
      call move_alloc(above, fields)
    end do
  end subroutine find_names

  pure subroutine next_above(lines, comments, separator, columns, n, fields)
    !! Go up to the next line of the requested kind, and split it; n = 0 if there is none.
    type(string), intent(in) :: lines(:)
    logical, intent(in) :: comments
    character, intent(in) :: separator
    integer, intent(in) :: columns                             !! number of columns
    integer, intent(inout) :: n
    type(string), allocatable, intent(out) :: fields(:)
    allocate (fields(0))
    do while (n > 1)
      n = n - 1
      if (is_comment(lines(n)%text) .neqv. comments) cycle
      fields = fields_of(uncommented(lines(n)%text), separator)
      if (separator == blanks) fields = joined(fields, columns)
      if (any_text(fields)) return
    end do
    n = 0
    fields = fields(:0)
  end subroutine next_above

  pure function joined(words, columns) result(fields)
    !! Return words between blanks without commas behind them, as in `time, a`; if these are more than the columns, with units in
    !! brackets as part of the word before, as in `time [ms] a [m/s2]`.
    type(string), intent(in) :: words(:)
    integer, intent(in) :: columns
    type(string), allocatable :: fields(:)
    integer :: i, n
    allocate (fields(0))
    do i = 1, size(words)
      n = size(fields)
      if (n > 0 .and. size(words) > columns .and. scan(words(i)%text, '[(') == 1) then
        fields(n)%text = fields(n)%text//' '//words(i)%text
      else
        fields = [fields, words(i)]
        n = n + 1
      end if
      associate (text => fields(n)%text)
        if (scan(text, ',;', back=.true.) == len(text) .and. len(text) > 1) fields(n)%text = text(:len(text) - 1)
      end associate
    end do
  end function joined

  pure function uncommented(line) result(text)
    !! Return a line without its comment mark.
    character(*), intent(in) :: line
    character(:), allocatable :: text
    text = line(max(1, verify(line, ' '//tab)):)
    if (text /= '') text = text(max(1, verify(text, '#%')):)
    if (verify(text, '#% ') == 0) text = ''
  end function uncommented

  pure logical function fits(fields, closed, columns)
    !! Return whether each column has a field, with at most one more: for an empty column, an empty field, or LabVIEW's `Comment`.
    type(string), intent(in) :: fields(:)
    logical, intent(in) :: closed
    integer, intent(in) :: columns
    fits = size(fields) == columns
    if (size(fields) == columns + 1) fits = closed .or. fields(columns + 1)%text == '' .or. &
      & lower(fields(columns + 1)%text) == 'comment'
    if (fits) fits = any_text(fields(:columns))
  end function fits

  pure logical function any_text(fields)
    !! Return whether some field is not empty.
    type(string), intent(in) :: fields(:)
    integer :: i
    any_text = .false.
    do i = 1, size(fields)
      any_text = any_text .or. fields(i)%text /= ''
    end do
  end function any_text

  pure logical function are_words(fields)
    !! Return whether all fields are words or empty.
    type(string), intent(in) :: fields(:)
    integer :: i
    are_words = count_words(fields) == count([(fields(i)%text /= '', i=1, size(fields))])
  end function are_words

  pure integer function count_words(fields) result(words)
    !! Count the fields that do not begin like a number, a date or a time of day.
    type(string), intent(in) :: fields(:)
    integer :: i
    words = 0
    do i = 1, size(fields)
      if (fields(i)%text == '') cycle
      if (verify(fields(i)%text(1:1), '0123456789+-.') > 0) words = words + 1
    end do
  end function count_words

  pure logical function are_units(fields, above, closed, columns)
    !! Return whether a line holds units: each field is one, or empty. If only some are known, the line above must have words over
    !! all fields, and these must not be units.
    type(string), intent(in) :: fields(:)
    type(string), intent(in) :: above(:)                       !! of the line above
    logical, intent(in) :: closed
    integer, intent(in) :: columns                             !! number of columns
    integer :: i, known, others
    known = 0
    others = 0
    do i = 1, size(fields)
      associate (text => fields(i)%text)
        if (verify(text, '-()[]') == 0) cycle                  ! no unit
        if (is_unit(plain_unit(text)) .or. plain_unit(text) /= text) then
          known = known + 1
        else
          others = others + 1
        end if
      end associate
    end do
    are_units = others == 0
    if (are_units .or. known == 0 .or. .not. fits(above, closed, columns)) return
    are_units = are_words(above(:columns))
    do i = 1, columns
      are_units = are_units .and. bare_name(fields(i)%text) /= 'time' .and. above(i)%text /= '' .and. &
        .not. is_unit(plain_unit(above(i)%text))
    end do
  end function are_units

  pure function plain_unit(text) result(unit)
    !! Return a unit without the brackets around it.
    character(*), intent(in) :: text
    character(:), allocatable :: unit
    unit = text
    if (verify(text, '-=()[]') == 0) unit = ''                 ! underlining of the names
    if (unit == '') return
    if ((text(1:1) == '[' .or. text(1:1) == '(') .and. unit_in(text) /= '') unit = unit_in(text)
  end function plain_unit

end module bw_text_header
