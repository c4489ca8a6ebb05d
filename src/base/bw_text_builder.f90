module bw_text_builder
  !! A text that grows piece by piece in time proportional to its length.
  implicit none (type, external)
  private

  type, public :: text_builder
    private
    character(:), allocatable :: buffer
    integer :: used = 0
  contains
    procedure :: append
    procedure :: append_line
    procedure :: text
  end type text_builder

contains

  pure subroutine append(self, piece)
    class(text_builder), intent(inout) :: self
    character(*), intent(in) :: piece
    character(:), allocatable :: wider
    if (.not. allocated(self%buffer)) allocate (character(1024) :: self%buffer)
    if (self%used + len(piece) > len(self%buffer)) then
      allocate (character(2*(self%used + len(piece))) :: wider)
      wider(:self%used) = self%buffer(:self%used)
      call move_alloc(wider, self%buffer)
    end if
    self%buffer(self%used + 1:self%used + len(piece)) = piece
    self%used = self%used + len(piece)
  end subroutine append

  pure subroutine append_line(self, piece)
    !! A piece and the end of its line.
    class(text_builder), intent(inout) :: self
    character(*), intent(in) :: piece
    call self%append(piece)
    call self%append(new_line('a'))
  end subroutine append_line

  pure function text(self)
    !! All that was appended.
    class(text_builder), intent(in) :: self
    character(:), allocatable :: text
    text = ''
    if (allocated(self%buffer)) text = self%buffer(:self%used)
  end function text

end module bw_text_builder
