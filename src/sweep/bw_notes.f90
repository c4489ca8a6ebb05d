module bw_notes
  !! The notes of a scene's cases, put together: in a sweep each kind of note is said once, for its first case, with the
  !! number of others that have it too. The kind is what stands before the first colon. The cases may come in any order.
  use bw_kinds, only: i8
  use bw_text, only: append, string, text_builder, text_of
  implicit none (type, external)
  private

  type :: kind_type
    !! One kind of note.
    integer(i8) :: first = 0                      !! the first case that has it
    integer :: place = 0                          !! where it stands among the notes of that case
    integer(i8) :: cases = 0                      !! how many have it
  end type kind_type

  type, public :: notes_type
    private
    type(kind_type), allocatable :: kinds(:)
    type(string), allocatable :: texts(:)         !! of the first case of each kind
  contains
    procedure :: add
    procedure :: lines
  end type notes_type

contains

  pure subroutine add(self, index, notes)
    !! Take account of the notes of a case.
    class(notes_type), intent(inout) :: self
    integer(i8), intent(in) :: index       !! of the case
    type(string), intent(in) :: notes(:)
    integer :: n, k
    if (.not. allocated(self%kinds)) allocate (self%kinds(0))
    do n = 1, size(notes)
      do k = 1, size(self%kinds)
        if (kind_of(self%texts(k)%text) == kind_of(notes(n)%text)) exit
      end do
      if (k > size(self%kinds)) then
        self%kinds = [self%kinds, kind_type(index, n, 0)]
        call append(self%texts, notes(n)%text)
      else if (index < self%kinds(k)%first) then
        self%kinds(k)%first = index
        self%kinds(k)%place = n
        self%texts(k)%text = notes(n)%text
      end if
      self%kinds(k)%cases = self%kinds(k)%cases + 1
    end do
  end subroutine add

  pure function kind_of(text) result(kind)
    !! The kind of a note: what stands before its first colon.
    character(*), intent(in) :: text
    character(:), allocatable :: kind
    kind = text(:index(text//':', ':') - 1)
  end function kind_of

  pure function lines(self, cases) result(text)
    !! The notes, one line for each kind, in the order of their first cases, with the ends of lines.
    class(notes_type), intent(in) :: self
    integer, intent(in) :: cases           !! of the sweep; 0 where there is none
    character(:), allocatable :: text
    type(text_builder) :: built
    logical, allocatable :: left(:)
    integer :: k
    text = ''
    if (.not. allocated(self%kinds)) return
    allocate (left(size(self%kinds)), source=.true.)
    do while (any(left))
      k = earliest(self%kinds, left)
      left(k) = .false.
      if (cases > 0) then
        call built%append('case '//text_of(self%kinds(k)%first))
        if (self%kinds(k)%cases > 1) call built%append(' (and '//text_of(self%kinds(k)%cases - 1)//' others of '// &
                                                       text_of(cases)//')')
        call built%append(': ')
      end if
      call built%append_line(self%texts(k)%text)
    end do
    text = built%text()
  end function lines

  pure integer function earliest(kinds, left) result(k)
    !! The place of the kind that comes first among those that are left.
    type(kind_type), intent(in) :: kinds(:)
    logical, intent(in) :: left(:)
    integer :: i
    k = findloc(left, .true., dim=1)
    do i = k + 1, size(kinds)
      if (.not. left(i)) cycle
      if (kinds(i)%first < kinds(k)%first .or. &
          (kinds(i)%first == kinds(k)%first .and. kinds(i)%place < kinds(k)%place)) k = i
    end do
  end function earliest

end module bw_notes
