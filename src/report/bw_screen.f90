module bw_screen
  !! The printed part of a report: one screen, or all with `--verbose`.
  !!
  !! A screen says what was simulated, the results, their accuracy and any warnings. Details are printed with
  !! `--verbose` only: single cases in sections on all, run times, further rows of a list, and all but the first line of
  !! notes. If the rest exceeds a screen, all lists are cut to the same number of rows. The number of trailing blanks
  !! marks the kind of a line, so that the report in a result remains plain text.
  use bw_text, only: lines_of, string, text_builder, text_of
  implicit none (type, external)
  private
  public :: details, printed

  character(*), parameter, public :: row_mark = ' '       !! ends a row of a list
  character(*), parameter, public :: detail_mark = '  '   !! ends a line that is a detail
  character(*), parameter, public :: note_mark = '  note: '   !! before a remark
  character(*), parameter, public :: note_hang = '    '   !! before the lines of a note but the first

  integer, parameter :: screen = 45                       !! lines
  integer, parameter :: fewest = 3                        !! rows of a list shown on any screen

contains

  pure function details(section) result(text)
    !! Mark all lines of a section as details. It begins with a blank line, or follows a line that is no row.
    character(*), intent(in) :: section           !! lines
    character(:), allocatable :: text
    type(string), allocatable :: lines(:)
    type(text_builder) :: built
    integer :: i
    lines = lines_of(section)
    do i = 1, size(lines)
      call built%append_line(trim(lines(i)%text)//detail_mark)
    end do
    text = built%text()
  end function details

  function printed(report, verbose) result(text)
    !! Return a report as printed, without marks; if it is cut, a line says how to see all.
    character(*), intent(in) :: report            !! lines
    logical, intent(in) :: verbose                !! all of it
    character(:), allocatable :: text
    type(string), allocatable :: lines(:)
    integer, allocatable :: rank(:)               ! of a row in its list; 0: not in a list, `huge`: a detail
    integer :: i, row, most, height
    logical :: in_note
    lines = lines_of(report)
    allocate (rank(size(lines)), source=0)
    row = 0
    do i = 1, merge(0, size(lines), verbose)
      associate (kind => len(lines(i)%text) - len_trim(lines(i)%text))
        row = merge(row + 1, 0, kind == len(row_mark))
        rank(i) = merge(huge(rank), row, kind >= len(detail_mark))
      end associate
    end do
    in_note = .false.
    do i = 1, merge(0, size(lines), verbose)
      in_note = in_note .and. index(lines(i)%text, note_hang) == 1
      if (in_note) then
        if (rank(i - 1) == 0) lines(i - 1)%text = lines(i - 1)%text//' ...'
        rank(i) = huge(rank)
      end if
      in_note = in_note .or. index(lines(i)%text, note_mark) == 1
    end do
    most = max(fewest, maxval(rank, mask=rank < huge(rank)))
    do
      call cut(lines, rank, most, text, height)
      if (height <= screen .or. most == fewest) exit
      most = most - 1
    end do
  end function printed

  subroutine cut(lines, rank, most, text, height)
    !! Print the lines up to a rank.
    type(string), intent(in) :: lines(:)
    integer, intent(in) :: rank(:), most
    character(:), allocatable, intent(out) :: text
    integer, intent(out) :: height                !! lines
    type(text_builder) :: built
    logical :: in_list
    integer :: i, rows, hidden
    height = 0
    hidden = 0
    rows = 0                                      ! hidden after the last row shown
    in_list = .false.
    do i = 1, size(lines)
      in_list = in_list .and. lines(i)%text /= ''
      if (rank(i) > most) then
        hidden = hidden + 1
        if (in_list) rows = rows + 1
        if (in_list) cycle
      end if
      if (rows > 0 .and. index(adjustl(lines(i)%text), '...') /= 1) call put('   ...  '//text_of(rows)//' more')
      rows = 0
      if (rank(i) > most) cycle
      in_list = rank(i) > 0
      call put(trim(lines(i)%text))
    end do
    if (rows > 0) call put('   ...  '//text_of(rows)//' more')
    if (hidden > 0) call put('  details    '//text_of(hidden)//' more lines with --verbose')
    text = built%text()
  contains
    subroutine put(line)
      character(*), intent(in) :: line
      call built%append_line(line)
      height = height + 1
    end subroutine put
  end subroutine cut

end module bw_screen
