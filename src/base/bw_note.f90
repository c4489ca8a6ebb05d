module bw_note
  !! Notes: remarks and warnings on a case, one line each. A warning must not be overlooked; a remark is a routine
  !! account of what was done, and is marked as such. The text before the first colon, without the mark, is the kind of
  !! a note.
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: is_remark, kind_of, remark, unmarked

  character(*), parameter, public :: remark_mark = 'remark: '

contains

  pure subroutine remark(notes, text)
    !! Add a remark; warnings are added without a mark.
    type(string), allocatable, intent(inout) :: notes(:)
    character(*), intent(in) :: text          !! without the mark
    call append(notes, remark_mark//text)
  end subroutine remark

  pure logical function is_remark(note)
    !! Return whether the note is a remark, else a warning.
    character(*), intent(in) :: note
    is_remark = index(note, remark_mark) == 1
  end function is_remark

  pure function unmarked(note) result(text)
    !! Return a note without the mark of a remark.
    character(*), intent(in) :: note
    character(:), allocatable :: text
    text = note
    if (is_remark(note)) text = note(len(remark_mark) + 1:)
  end function unmarked

  pure function kind_of(note) result(kind)
    !! Return the kind of a note: the text before its first colon.
    character(*), intent(in) :: note
    character(:), allocatable :: kind
    kind = unmarked(note)
    kind = kind(:index(kind//':', ':') - 1)
  end function kind_of

end module bw_note
