module bw_text_header
  !! What the lines before the rows of a table say: the names of its columns, and their units.
  use bw_record, only: bare_name, column_type, unit_in
  use bw_sensor_unit, only: is_unit, quantity_of
  use bw_text, only: string
  use bw_text_fields, only: fields_of, tab
  implicit none (type, external)
  private
  public :: is_comment, name_columns

contains

  pure logical function is_comment(line)
    !! The line says nothing to the table: it is empty, or a comment.
    character(*), intent(in) :: line
    integer :: first
    first = verify(line, ' '//tab)
    is_comment = first == 0
    if (first > 0) is_comment = line(first:first) == '#' .or. line(first:first) == '%'
  end function is_comment

  subroutine name_columns(lines, separator, closed, columns)
    !! Names from the last line of the header with as many fields as there are columns, or from the one before where that holds
    !! units; from a comment where no other line does.
    type(string), intent(in) :: lines(:)                       !! of the header
    character, intent(in) :: separator
    logical, intent(in) :: closed                              !! a separator stands behind the last field, too
    type(column_type), intent(inout) :: columns(:)
    type(string), allocatable :: names(:), units(:)
    integer :: n, kind, i
    allocate (names(0), units(0))
    do kind = 1, 2                                             ! header lines, comments
      do n = size(lines), 1, -1
        if (is_comment(lines(n)%text) .neqv. kind == 2) cycle
        call take_names(fields_of(uncommented(lines(n)%text), separator), closed, size(columns), names, units)
        if (size(names) > 0) exit
      end do
      if (size(names) > 0) exit
    end do
    do i = 1, size(columns)
      associate (column => columns(i))
        if (size(names) > 0) column%name = names(i)%text
        column%unit = unit_in(column%name)
        if (size(units) > 0) column%unit = plain_unit(units(i)%text)
        column%quantity = quantity_of(column%unit)
        column%is_time = bare_name(column%name) == 'time' .or. bare_name(column%name) == 't'
      end associate
    end do
  end subroutine name_columns

  pure subroutine take_names(fields, closed, columns, names, units)
    !! What a line of the header holds, if it has as many fields as there are columns.
    type(string), intent(in) :: fields(:)
    logical, intent(in) :: closed                              !! as above
    integer, intent(in) :: columns                             !! how many there are
    type(string), allocatable, intent(inout) :: names(:), units(:)
    integer :: n
    n = size(fields)
    if (closed .and. n == columns + 1) n = n - 1
    if (n /= columns) return
    if (size(units) == 0 .and. are_units(fields(:n))) then
      units = fields(:n)
    else
      names = fields(:n)
    end if
  end subroutine take_names

  pure function uncommented(line) result(text)
    !! A line without the mark of a comment before it.
    character(*), intent(in) :: line
    character(:), allocatable :: text
    text = line(max(1, verify(line, ' '//tab)):)
    if (text /= '') text = text(max(1, verify(text, '#%')):)
    if (verify(text, '#% ') == 0) text = ''
  end function uncommented

  pure logical function are_units(fields)
    !! A line of units: each field is one, or is empty, and one at least is there.
    type(string), intent(in) :: fields(:)
    integer :: i
    are_units = .false.
    do i = 1, size(fields)
      if (verify(fields(i)%text, '-()[]') == 0) cycle        ! it has none
      are_units = is_unit(plain_unit(fields(i)%text))
      if (.not. are_units .and. unit_in(fields(i)%text) /= '') are_units = plain_unit(fields(i)%text) /= fields(i)%text
      if (.not. are_units) return
    end do
  end function are_units

  pure function plain_unit(text) result(unit)
    !! A unit without the brackets around it.
    character(*), intent(in) :: text
    character(:), allocatable :: unit
    unit = text
    if (len(text) == 0) return
    if ((text(1:1) == '[' .or. text(1:1) == '(') .and. unit_in(text) /= '') unit = unit_in(text)
  end function plain_unit

end module bw_text_header
