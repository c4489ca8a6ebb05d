module bw_scene_messages
  !! All that is wrong with a scene, collected while it is read and shown in the order of its lines.
  use bw_text, only: text_of
  use bw_text_builder, only: text_builder
  implicit none (type, external)
  private

  integer, parameter :: most_messages = 1000  !! who reads more, and where would they all be kept

  type :: located_message
    integer :: line = 0
    character(:), allocatable :: text
  end type located_message

  type, public :: message_list
    character(:), allocatable :: file         !! the scene's path, as the user wrote it
    integer :: count = 0                      !! of all errors, listed or not
    logical :: cut = .false.                  !! more is wrong than is listed: whoever reads on may stop
    type(located_message), allocatable, private :: items(:)
  contains
    procedure :: add
    procedure :: text
  end type message_list

contains

  pure subroutine add(self, line, place, what)
    !! Add `FILE:LINE: place: what`.
    class(message_list), intent(inout) :: self
    integer, intent(in) :: line               !! 0 for something absent: `FILE: place: what`
    character(*), intent(in) :: place         !! `group%name` or `&group`
    character(*), intent(in) :: what          !! what is wrong, and what would be accepted
    self%count = self%count + 1
    self%cut = self%count > most_messages
    if (self%cut) return
    if (.not. allocated(self%items)) allocate (self%items(8))
    if (self%count > size(self%items)) call grow(self%items)
    self%items(self%count)%line = line
    if (line > 0) then
      self%items(self%count)%text = self%file//':'//text_of(line)//': '//place//': '//what
    else
      self%items(self%count)%text = self%file//': '//place//': '//what
    end if
  end subroutine add

  pure subroutine grow(items)
    type(located_message), allocatable, intent(inout) :: items(:)
    type(located_message), allocatable :: more(:)
    integer :: i
    allocate (more(2*size(items)))
    do i = 1, size(items)
      more(i)%line = items(i)%line
      call move_alloc(items(i)%text, more(i)%text)
    end do
    call move_alloc(more, items)
  end subroutine grow

  pure function text(self)
    !! One message per line, by line of the scene; what is absent comes last.
    class(message_list), intent(in) :: self
    character(:), allocatable :: text
    type(text_builder) :: builder
    integer :: order(min(self%count, most_messages)), i
    order = by_line(self%items(:size(order))%line)
    do i = 1, size(order)
      if (i > 1) call builder%append(new_line('a'))
      call builder%append(self%items(order(i))%text)
    end do
    if (self%cut) call builder%append(new_line('a')//self%file//': text: more is wrong than these '//text_of(most_messages)// &
                                      ' errors; what else there is was not looked at')
    text = builder%text()
  end function text

  pure function by_line(lines) result(order)
    !! Stable insertion sort; line 0 counts as the last. The lists are short or nearly in order.
    integer, intent(in) :: lines(:)
    integer :: order(size(lines))
    integer :: i, j
    do i = 1, size(lines)
      j = i
      do while (j > 1)
        if (key(lines(order(j - 1))) <= key(lines(i))) exit
        order(j) = order(j - 1)
        j = j - 1
      end do
      order(j) = i
    end do
  end function by_line

  pure integer function key(line)
    integer, intent(in) :: line
    key = merge(huge(line), line, line == 0)
  end function key

end module bw_scene_messages
