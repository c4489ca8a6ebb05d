module bw_scene_messages
  !! All that is wrong with a scene, collected while it is read and shown in the order of its lines; how messages show pieces
  !! of a scene, and what they say of products of inputs that do not fit into double precision.
  use bw_kinds, only: dp, qp
  use bw_scene_tokens, only: is_utf8, name_characters
  use bw_text, only: text_builder, text_of
  implicit none (type, external)
  private
  public :: round_product, shown

  integer, parameter :: most_messages = 1000  !! nobody reads more, and memory is bounded

  type :: located_message
    integer :: line = 0
    integer :: row = 0
    character(:), allocatable :: text
  end type located_message

  type, public :: message_list
    character(:), allocatable :: file         !! the scene's path, as the user wrote it
    character(:), allocatable :: case         !! that is looked at, as ` (in the case a = 1)`; unallocated: the scene as it is
    character(:), allocatable :: table        !! of which a row is looked at, its path; unallocated: none is
    integer :: table_line = 0                 !! of the scene, which names the table
    integer :: row = 0                        !! line of the table; 0: all of it is looked at
    integer :: count = 0                      !! of all errors, listed or not
    logical :: cut = .false.                  !! more is wrong than is listed: whoever reads on may stop
    type(located_message), allocatable, private :: items(:)
  contains
    procedure :: add
    procedure :: enter_row
    procedure :: leave_row
    procedure :: text => text_of_list
  end type message_list

contains

  pure subroutine add(self, line, place, what)
    !! Add `FILE:LINE: place: what`. Of what comes from the row of a table that is looked at, FILE:LINE is that of the row.
    class(message_list), intent(inout) :: self
    integer, intent(in) :: line               !! 0 for something absent: `FILE: place: what`
    character(*), intent(in) :: place         !! `group%name` or `&group`
    character(*), intent(in) :: what          !! what is wrong, and what would be accepted
    if (.not. allocated(self%file)) self%file = ''   ! of a list that is only counted
    self%count = self%count + 1
    self%cut = self%count > most_messages
    if (self%cut) return
    if (.not. allocated(self%items)) allocate (self%items(8))
    if (self%count > size(self%items)) call grow(self%items)
    associate (message => self%items(self%count))
      message%line = line
      message%row = self%row
      message%text = placed(self%file, line)
      if (allocated(self%table) .and. line == self%table_line) message%text = placed(self%table, self%row)
      message%text = message%text//': '//place//': '//what
      if (allocated(self%table) .and. line /= self%table_line) message%text = message%text//' (with '// &
        placed(self%table, self%row)//')'
      if (allocated(self%case)) message%text = message%text//self%case
    end associate
  end subroutine add

  pure function placed(file, line) result(text)
    !! `FILE:LINE`, or the file alone with the line 0.
    character(*), intent(in) :: file
    integer, intent(in) :: line
    character(:), allocatable :: text
    text = file
    if (line > 0) text = text//':'//text_of(line)
  end function placed

  pure subroutine enter_row(self, table, row, line)
    !! From here on a row of a table is looked at.
    class(message_list), intent(inout) :: self
    character(*), intent(in) :: table         !! its path
    integer, intent(in) :: row                !! line of the table; 0: all of it is looked at
    integer, intent(in) :: line               !! of the scene, which names the table
    self%table = table
    self%row = row
    self%table_line = line
  end subroutine enter_row

  pure subroutine leave_row(self)
    !! From here on the scene itself is looked at.
    class(message_list), intent(inout) :: self
    self%row = 0
    if (allocated(self%table)) deallocate (self%table)
  end subroutine leave_row

  pure subroutine grow(items)
    !! Twice as much room.
    type(located_message), allocatable, intent(inout) :: items(:)
    type(located_message), allocatable :: more(:)
    integer :: i
    allocate (more(2*size(items)))
    do i = 1, size(items)
      more(i)%line = items(i)%line
      more(i)%row = items(i)%row
      call move_alloc(items(i)%text, more(i)%text)
    end do
    call move_alloc(more, items)
  end subroutine grow

  pure function text_of_list(self) result(text)
    !! One message per line, by line of the scene; what is absent comes last.
    class(message_list), intent(in) :: self
    character(:), allocatable :: text
    type(text_builder) :: builder
    integer :: order(min(self%count, most_messages)), i
    order = by_line(self%items(:size(order)))
    do i = 1, size(order)
      if (i > 1) call builder%append(new_line('a'))
      call builder%append(self%items(order(i))%text)
    end do
    if (self%cut) call builder%append(new_line('a')//self%file//': text: there are more than these '//text_of(most_messages)// &
                                      ' errors; further ones are not listed')
    text = builder%text()
  end function text_of_list

  pure function by_line(items) result(order)
    !! Stable insertion sort by line, and by row of a table; line 0 counts as the last. The lists are short or nearly in order.
    type(located_message), intent(in) :: items(:)
    integer :: order(size(items))
    integer :: i, j
    do i = 1, size(items)
      j = i
      do while (j > 1)
        if (.not. is_later(items(order(j - 1)), items(i))) exit
        order(j) = order(j - 1)
        j = j - 1
      end do
      order(j) = i
    end do
  end function by_line

  pure logical function is_later(one, other)
    !! The one message stands behind the other.
    type(located_message), intent(in) :: one, other
    is_later = key(one%line) > key(other%line) .or. (one%line == other%line .and. one%row > other%row)
  end function is_later

  pure integer function key(line)
    !! What messages are sorted by.
    integer, intent(in) :: line
    key = merge(huge(line), line, line == 0)
  end function key

  pure subroutine round_product(product, value, line, place, what, messages)
    !! Round a product to double precision; where it overflows or loses digits to underflow, say so.
    real(qp), intent(in) :: product
    real(dp), intent(out) :: value
    integer, intent(in) :: line
    character(*), intent(in) :: place          !! an input that it depends on
    character(*), intent(in) :: what           !! what the product is
    type(message_list), intent(inout) :: messages
    value = 0.0_dp
    if (abs(product) > huge(1.0_dp)) then
      call messages%add(line, place, what//' is too large for double precision; accepted: at most 1.79e308')
    else if (product /= 0.0_qp .and. abs(product) < tiny(1.0_dp)) then
      call messages%add(line, place, what//' is too small for double precision; accepted: at least 2.23e-308')
    else
      value = real(product, dp)
    end if
  end subroutine round_product

  pure function shown(text) result(piece)
    !! A piece of the scene, shortened, as a message may show it.
    character(*), intent(in) :: text
    character(:), allocatable :: piece
    integer, parameter :: most = 40
    integer :: i, last
    last = min(len(text), most)
    if (last < len(text)) last = scan(text(:last), name_characters//' .,+-', back=.true.)
    if (.not. is_utf8(text(:last))) then
      piece = '(not UTF-8)'
      return
    end if
    piece = text(:last)
    do i = 1, last
      if (iachar(piece(i:i)) < 32) piece(i:i) = ' '
    end do
    if (last < len(text)) piece = piece//'...'
    piece = "'"//piece//"'"
  end function shown

end module bw_scene_messages
