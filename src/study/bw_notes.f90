module bw_notes
  !! The notes of a scene's cases, put together: in a sweep each kind of note is said once, for its first case, with the
  !! number of others that have it too. The kind is what stands before the first colon.
  use bw_kinds, only: i8
  use bw_text, only: append, string, text_of
  implicit none (type, external)
  private

  integer, parameter :: most_kinds = 100

  type, public :: notes_type
    private
    integer :: count = 0                          !! kinds of notes
    type(string), allocatable :: texts(:)         !! of the first case of each kind
    integer(i8) :: first(most_kinds) = 0
    integer(i8) :: others(most_kinds) = 0
  contains
    procedure :: add
    procedure :: lines
  end type notes_type

contains

  pure subroutine add(self, index, notes)
    !! Take account of a case.
    class(notes_type), intent(inout) :: self
    integer(i8), intent(in) :: index       !! of the case
    type(string), intent(in) :: notes(:)
    integer :: n, k
    do n = 1, size(notes)
      do k = 1, self%count
        if (kind_of(self%texts(k)%text) == kind_of(notes(n)%text)) exit
      end do
      if (k <= self%count) then
        self%others(k) = self%others(k) + 1
      else if (self%count < most_kinds) then
        self%count = k
        self%first(k) = index
        call append(self%texts, notes(n)%text)
      end if
    end do
  end subroutine add

  pure function kind_of(text) result(kind)
    character(*), intent(in) :: text
    character(:), allocatable :: kind
    kind = text(:index(text//':', ':') - 1)
  end function kind_of

  pure function lines(self, cases) result(text)
    !! One line for each kind, line ends included.
    class(notes_type), intent(in) :: self
    integer, intent(in) :: cases           !! of the sweep; 0 where there is none
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, self%count
      if (cases > 0) then
        text = text//'case '//text_of(self%first(k))
        if (self%others(k) > 0) text = text//' (and '//text_of(self%others(k))//' others of '//text_of(cases)//')'
        text = text//': '
      end if
      text = text//self%texts(k)%text//new_line('a')
    end do
  end function lines

end module bw_notes
