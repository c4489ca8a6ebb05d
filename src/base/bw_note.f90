module bw_note
  !! Notes: what there is to say of a case beside its numbers, one line each. A warning says what a reader must not overlook; a
  !! remark gives a routine account of what was done, and is marked as such. The words before the first colon, the mark apart,
  !! are the kind of a note.
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: is_remark, kind_of, remark, unmarked

  character(*), parameter, public :: remark_mark = 'remark: '

contains

  pure subroutine remark(notes, text)
    !! Add a remark; warnings are added as they stand.
    type(string), allocatable, intent(inout) :: notes(:)
    character(*), intent(in) :: text          !! without the mark
    call append(notes, remark_mark//text)
  end subroutine remark

  pure logical function is_remark(note)
    !! The note is a remark, else a warning.
    character(*), intent(in) :: note
    is_remark = index(note, remark_mark) == 1
  end function is_remark

  pure function unmarked(note) result(text)
    !! A note without the mark of a remark.
    character(*), intent(in) :: note
    character(:), allocatable :: text
    text = note
    if (is_remark(note)) text = note(len(remark_mark) + 1:)
  end function unmarked

  pure function kind_of(note) result(kind)
    !! The kind of a note: what stands before its first colon.
    character(*), intent(in) :: note
    character(:), allocatable :: kind
    kind = unmarked(note)
    kind = kind(:index(kind//':', ':') - 1)
  end function kind_of

end module bw_note
