module bw_scene_messages
  !! The errors of a scene, collected while it is read and shown in the order of its lines; how messages quote the scene,
  !! and what they say of products of inputs that overflow or underflow in double precision.
  use bw_kinds, only: dp, qp
  use bw_scene_tokens, only: is_utf8, name_characters
  use bw_text, only: text_builder, text_of
  implicit none (type, external)
  private
  public :: round_product, shown

  integer, parameter :: most_messages = 1000  !! enough for any reader; bounds the memory

  type :: located_message
    integer :: line = 0
    integer :: row = 0
    character(:), allocatable :: text
  end type located_message

  type, public :: message_list
    character(:), allocatable :: file         !! the scene's path, as the user gave it
    character(:), allocatable :: case         !! current case, as ` (in the case a = 1)`; unallocated: the scene as it is
    character(:), allocatable :: table        !! path of the table whose row is checked; unallocated: none
    integer :: table_line = 0                 !! line of the scene that names the table
    integer :: row = 0                        !! current line of the table; 0: the whole table
    integer :: count = 0                      !! of all errors, listed or not
    logical :: cut = .false.                  !! there are more errors than are listed: reading may stop
    type(located_message), allocatable, private :: items(:)
  contains
    procedure :: add
    procedure :: enter_row
    procedure :: leave_row
    procedure :: text => text_of_list
  end type message_list

contains

  pure subroutine add(self, line, place, what)
    !! Add `FILE:LINE: place: what`. For a value from a row of the current table, FILE:LINE is that of the row.
    class(message_list), intent(inout) :: self
    integer, intent(in) :: line               !! 0 for something absent: `FILE: place: what`
    character(*), intent(in) :: place         !! `group%name` or `&group`
    character(*), intent(in) :: what          !! what is wrong, and what would be accepted
    if (.not. allocated(self%file)) self%file = ''   ! in a list that is only counted
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
    !! Return `FILE:LINE`, or the file alone for line 0.
    character(*), intent(in) :: file
    integer, intent(in) :: line
    character(:), allocatable :: text
    text = file
    if (line > 0) text = text//':'//text_of(line)
  end function placed

  pure subroutine enter_row(self, table, row, line)
    !! Attribute further messages to a row of a table.
    class(message_list), intent(inout) :: self
    character(*), intent(in) :: table         !! its path
    integer, intent(in) :: row                !! line of the table; 0: the whole table
    integer, intent(in) :: line               !! line of the scene that names the table
    self%table = table
    self%row = row
    self%table_line = line
  end subroutine enter_row

  pure subroutine leave_row(self)
    !! Attribute further messages to the scene itself.
    class(message_list), intent(inout) :: self
    self%row = 0
    if (allocated(self%table)) deallocate (self%table)
  end subroutine leave_row

  pure subroutine grow(items)
    !! Double the capacity.
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
    !! Return one message per line, by line of the scene; messages without a line come last.
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
    !! Sort stably by line, and by row of a table (insertion sort); line 0 counts as the last. Lists are short or nearly sorted.
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
    !! Return whether one message comes after the other.
    type(located_message), intent(in) :: one, other
    is_later = key(one%line) > key(other%line) .or. (one%line == other%line .and. one%row > other%row)
  end function is_later

  pure integer function key(line)
    !! Return the key by which messages are sorted.
    integer, intent(in) :: line
    key = merge(huge(line), line, line == 0)
  end function key

  pure subroutine round_product(product, value, line, place, what, messages)
    !! Round a product to double precision; report overflow, and underflow that loses digits.
    real(qp), intent(in) :: product
    real(dp), intent(out) :: value
    integer, intent(in) :: line
    character(*), intent(in) :: place          !! an input on which it depends
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
    !! Return a piece of the scene, shortened for a message.
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
