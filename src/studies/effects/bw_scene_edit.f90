module bw_scene_edit
  !! The text of a resolved scene with groups taken out, put in or changed: what results is read and checked like any
  !! other scene, so that what cannot be combined is refused with the reader's own reason.
  implicit none (type, external)
  private
  public :: has_group, with_group, with_value, without_group

  character(*), parameter :: nl = new_line('a')

contains

  pure logical function has_group(text, group)
    !! The text has a group of that name.
    character(*), intent(in) :: text               !! as `resolved_text` writes it: each group and name on its own line
    character(*), intent(in) :: group
    has_group = start_of(text, group) > 0
  end function has_group

  pure function without_group(text, group) result(edited)
    !! The same text where the group is not there.
    character(*), intent(in) :: text, group
    character(:), allocatable :: edited
    integer :: first, last
    edited = text
    first = start_of(text, group)
    if (first == 0) return
    last = end_of(text, first)
    edited = text(:first - 1)//text(last + 1:)
  end function without_group

  pure function with_group(text, group, values) result(edited)
    !! A group that is there is replaced.
    character(*), intent(in) :: text, group
    character(*), intent(in) :: values             !! `name = value`; empty: all defaults
    character(:), allocatable :: edited
    edited = without_group(text, group)//'&'//group//nl
    if (values /= '') edited = edited//'  '//values//nl
    edited = edited//'/'//nl
  end function with_group

  pure function with_value(text, group, name, value) result(edited)
    !! A name of a group that is there gets another value.
    character(*), intent(in) :: text, group, name
    character(*), intent(in) :: value              !! empty: the name is taken out
    character(:), allocatable :: edited
    integer :: first, last, line, rest
    first = start_of(text, group)
    last = end_of(text, first)
    first = first + index(text(first:last), nl)    ! behind the line with the group's name
    line = index(nl//text(first:last), nl//'  '//name//' = ')
    rest = first
    if (line > 0) then
      first = first + line - 1
      rest = first + index(text(first:last), nl)
    end if
    edited = text(:first - 1)
    if (value /= '') edited = edited//'  '//name//' = '//value//nl
    edited = edited//text(rest:)
  end function with_value

  pure integer function start_of(text, group) result(first)
    !! Of the line that opens the group; 0 where there is none. A line inside a group begins with a blank or is '/'.
    character(*), intent(in) :: text, group
    first = index(nl//text, nl//'&'//group//nl)
  end function start_of

  pure integer function end_of(text, first) result(last)
    !! The last character of the line that closes the group which opens at `first`.
    character(*), intent(in) :: text
    integer, intent(in) :: first
    last = first + index(text(first:), nl//'/'//nl) + 1
  end function end_of

end module bw_scene_edit
