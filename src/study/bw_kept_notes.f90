module bw_kept_notes
  !! The notes of a sweep's finished cases, kept beside its unfinished result, so that a run that goes on from there ends
  !! with the notes of one that was never interrupted.
  use bw_kinds, only: i8
  use bw_notes, only: notes_type
  use bw_posix, only: remove_file
  use bw_text, only: append, string, text_of
  implicit none (type, external)
  private
  public :: keep_notes, take_kept_notes

  integer, parameter :: longest_line = 10000   !! of a note; longer ones are cut

contains

  subroutine keep_notes(path, index, notes)
    !! Append a case's notes, one to a line, behind its number. What cannot be written is not kept: the result's own file
    !! tells of a full disk.
    character(*), intent(in) :: path
    integer(i8), intent(in) :: index       !! of the case
    type(string), intent(in) :: notes(:)
    integer :: unit, stat, n
    if (size(notes) == 0) return
    open (newunit=unit, file=path, position='append', action='write', iostat=stat)
    if (stat /= 0) return
    do n = 1, size(notes)
      write (unit, '(a)', iostat=stat) text_of(index)//' '//notes(n)%text
    end do
    close (unit, iostat=stat)
  end subroutine keep_notes

  subroutine take_kept_notes(path, finished, notes)
    !! The notes of the cases that the unfinished result holds. Those of others were cut off with their case, which will
    !! be done again: they are dropped from the file.
    character(*), intent(in) :: path
    logical, intent(in) :: finished(:)     !! (cases)
    type(notes_type), intent(inout) :: notes
    integer(i8), allocatable :: indices(:)
    type(string), allocatable :: lines(:)
    type(string) :: note(1)
    integer :: n
    call read_lines(path, lines, indices)
    call remove_file(path)
    do n = 1, size(lines)
      if (indices(n) < 1 .or. indices(n) > size(finished, kind=i8)) cycle
      if (.not. finished(indices(n))) cycle
      note(1)%text = lines(n)%text(scan(lines(n)%text, ' ') + 1:)
      call notes%add(indices(n), note)
      call keep_notes(path, indices(n), note)
    end do
  end subroutine take_kept_notes

  subroutine read_lines(path, lines, indices)
    !! All lines of a file that begin with a number.
    character(*), intent(in) :: path
    type(string), allocatable, intent(out) :: lines(:)
    integer(i8), allocatable, intent(out) :: indices(:)
    character(longest_line) :: line
    integer(i8) :: index
    integer :: unit, stat, number
    allocate (lines(0), indices(0))
    open (newunit=unit, file=path, status='old', action='read', iostat=stat)
    if (stat /= 0) return
    do
      read (unit, '(a)', iostat=stat) line
      if (stat /= 0) exit
      read (line, *, iostat=number) index
      if (number /= 0) cycle
      call append(lines, line(:len_trim(line)))
      indices = [indices, index]
    end do
    close (unit, iostat=stat)
  end subroutine read_lines

end module bw_kept_notes
