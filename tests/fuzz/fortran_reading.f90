module fortran_reading
  !! An independent opinion of what a text says: the namelist input of the compiler's own library. It takes more than
  !! scenes may hold and says less when it refuses, but what it reads, it reads as the language defines.
  use bw_input_name, only: columns_input
  use bw_input_table, only: group_table, name_table
  use bw_input_values, only: group_values, positions_of
  use bw_kinds, only: dp
  use bw_scene, only: scene_type
  use bw_sweep_par, only: sweep_par
  use bw_text, only: lower
  use fortran_groups, only: read_group
  use read_comparison, only: comparison, longest_text, most_values, same_reals, unset, unset_whole
  implicit none (type, external)
  private
  public :: compare_with_fortran

  type, public :: reading_type
    integer :: compared = 0      !! groups that both readers read
    integer :: unread = 0        !! sweeps that Fortran cannot find, another group standing before them in a line
  end type reading_type

  character, parameter :: nl = new_line('a'), carriage_return = achar(13)
contains

  subroutine compare_with_fortran(text, scene, reading, fault)
    !! Look for a value, given or absent, that the two readers see differently.
    character(*), intent(in) :: text
    type(scene_type), intent(in) :: scene            !! accepted from this text
    type(reading_type), intent(inout) :: reading
    character(:), allocatable, intent(out) :: fault  !! empty for none
    fault = ''
    call compare_lines(lines_of(text), text, scene, reading, fault)
  end subroutine compare_with_fortran

  subroutine compare_lines(lines, text, scene, reading, fault)
    !! Compare what the lines of a text hold, unless gfortran misreads them.
    character(*), intent(in) :: lines(:), text
    type(scene_type), intent(in) :: scene
    type(reading_type), intent(inout) :: reading
    character(:), allocatable, intent(inout) :: fault
    type(group_values), allocatable :: groups(:)
    integer, allocatable :: places(:)
    integer :: i, g
    call leave_unknowns_out(scene, groups)
    if (misreads(text, lines, scene%header%title)) return
    do i = 1, size(group_table)
      if (group_table(i)%name == 'sweep') cycle
      places = [positions_of(groups, group_table(i)%name), 0]
      do g = 1, max(1, size(places) - 1)
        if (fault == '') call compare_group(lines, groups, places(g), trim(group_table(i)%name), reading, fault)
      end do
    end do
    if (fault == '') call compare_sweeps(lines, pack(scene%sweeps, .not. scene%sweeps%implied), reading, fault)
  end subroutine compare_lines

  subroutine leave_unknowns_out(scene, groups)
    !! What a scene says, its unknowns as if swept: their values need not be those of the text.
    type(scene_type), intent(in) :: scene
    type(group_values), allocatable, intent(out) :: groups(:)
    integer :: i
    groups = scene%groups
    do i = 1, size(scene%unknowns)
      groups(scene%unknowns(i)%group)%values(scene%unknowns(i)%value)%sweeps = 1
    end do
  end subroutine leave_unknowns_out

  function lines_of(text) result(lines)
    !! The lines of a text, padded with blanks, without the returns of CR LF.
    character(*), intent(in) :: text
    character(:), allocatable :: lines(:)
    integer, allocatable :: ends(:)
    integer :: i, first, last
    ends = pack([(i, i=1, len(text))], [(text(i:i) == nl, i=1, len(text))])
    ends = [ends, len(text) + 1]
    allocate (character(1 + maxval(ends - [0, ends(:size(ends) - 1)])) :: lines(size(ends)))
    first = 1
    do i = 1, size(ends)
      last = ends(i) - 1
      if (last >= first) then
        if (text(last:last) == carriage_return) last = last - 1
      end if
      lines(i) = text(first:last)
      first = ends(i) + 1
    end do
  end function lines_of

  pure logical function misreads(text, lines, title)
    !! What gfortran 12 reads otherwise than the language defines: it looks for groups within texts, too, takes a comma
    !! that opens a line for a second one, and byte 255 for the end of a file.
    character(*), intent(in) :: text, lines(:), title
    misreads = scan(title, '&$') > 0 .or. any(opens_with_comma(lines)) .or. index(text, char(255)) > 0
  end function misreads

  elemental logical function opens_with_comma(line)
    character(*), intent(in) :: line
    integer :: first
    first = verify(line, ' '//achar(9))
    opens_with_comma = .false.
    if (first > 0) opens_with_comma = line(first:first) == ','
  end function opens_with_comma

  subroutine compare_group(lines, groups, g, name, reading, fault)
    !! One group of the scene; where several share a line Fortran sees the first of them.
    character(*), intent(in) :: lines(:), name
    type(group_values), intent(in) :: groups(:)
    integer, intent(in) :: g                         !! its place among the groups; 0: there is none
    type(reading_type), intent(inout) :: reading
    character(:), allocatable, intent(inout) :: fault
    type(comparison) :: both
    integer :: first
    both%differing = ''
    first = 0
    if (g > 0) both%group = groups(g)
    if (g > 0) first = groups(g)%line
    if (g > 0) then
      if (names_a_column(groups(g))) return
    end if
    if (count(groups%group == name .and. groups%line == first) > 1) then
      reading%unread = reading%unread + 1
      return
    end if
    call read_group(lines(max(1, first):), name, both)
    if (first == 0) then
      if (both%differing /= '' .or. size(openings(lines, name)) > 0) fault = '&'//name//' is there, and was not read'
      return
    end if
    reading%compared = reading%compared + 1
    if (both%differing /= '') fault = name//'%'//both%differing//' is read otherwise by Fortran'
    if (both%stat /= 0) fault = '&'//name//' is accepted, and Fortran refuses it'
    if (index(lower(lines(first)), '&'//name) == 0) fault = '&'//name//' is not where it was read'
  end subroutine compare_group

  pure logical function names_a_column(group)
    !! Whether a group gives a name or number of a column: Fortran has no value that may be either.
    type(group_values), intent(in) :: group
    integer :: i
    names_a_column = .false.
    do i = 1, size(group%values)
      if (group%values(i)%given) names_a_column = names_a_column .or. name_table(group%values(i)%row)%kind == columns_input
    end do
  end function names_a_column

  subroutine compare_sweeps(lines, sweeps, reading, fault)
    !! Each `&sweep` that opens a line; where two share a line Fortran sees one.
    character(*), intent(in) :: lines(:)
    type(sweep_par), intent(in) :: sweeps(:)
    type(reading_type), intent(inout) :: reading
    character(:), allocatable, intent(inout) :: fault
    integer, allocatable :: starts(:)
    integer :: i
    starts = openings(lines, 'sweep')
    if (size(starts) > size(sweeps)) fault = 'a sweep is lost'
    if (size(starts) < size(sweeps)) reading%unread = reading%unread + size(sweeps)
    if (size(starts) /= size(sweeps)) return
    do i = 1, size(sweeps)
      call compare_sweep(lines(starts(i):), sweeps(i), fault)
      reading%compared = reading%compared + 1
    end do
  end subroutine compare_sweeps

  pure function openings(lines, name) result(starts)
    !! The lines that begin with `&name`.
    character(*), intent(in) :: lines(:), name
    integer, allocatable :: starts(:)
    integer :: i
    starts = pack([(i, i=1, size(lines))], [(opens(lines(i), '&'//name), i=1, size(lines))])
  end function openings

  pure logical function opens(line, start)
    character(*), intent(in) :: line, start
    integer :: first, behind
    first = max(1, verify(line, ' '//achar(9)))
    behind = first + len(start)
    opens = .false.
    if (behind > len(line)) return
    opens = lower(line(first:behind - 1)) == start .and. scan(line(behind:behind), ' /!'//achar(9)) == 1
  end function opens

  subroutine compare_sweep(lines, held, fault)
    character(*), intent(in) :: lines(:)
    type(sweep_par), intent(in) :: held
    character(:), allocatable, intent(inout) :: fault
    character(longest_text) :: parameter, spacing
    real(dp) :: values(most_values), first, last
    integer :: count, n, stat
    namelist /sweep/ parameter, values, first, last, count, spacing
    parameter = ''
    spacing = 'linear'                              ! the default
    values = unset
    first = unset
    last = unset
    count = unset_whole
    read (lines, nml=sweep, iostat=stat)
    if (stat /= 0) fault = 'a sweep is accepted, and Fortran refuses it'
    n = size(held%values)
    if (without_numbers(lower(parameter)) /= without_numbers(held%parameter)) fault = 'sweep%parameter'
    if (held%spacing == '') then
      if (.not. same_reals(held%values, values)) fault = 'sweep%values'
    else if (values(1) /= unset .or. first /= held%values(1) .or. last /= held%values(n) .or. count /= n &
             .or. lower(spacing) /= held%spacing) then
      fault = 'sweep between two ends'
    end if
  end subroutine compare_sweep

  pure function without_numbers(parameter) result(text)
    !! The names alone: `body(02)%mass` is held as `body(2)%mass`, and with one body as `body%mass`.
    character(*), intent(in) :: parameter
    character(:), allocatable :: text
    integer :: i
    logical :: inside
    text = ''
    inside = .false.
    do i = 1, len_trim(parameter)
      if (parameter(i:i) == '(') inside = .true.
      if (.not. inside) text = text//parameter(i:i)
      if (parameter(i:i) == ')') inside = .false.
    end do
  end function without_numbers

end module fortran_reading
