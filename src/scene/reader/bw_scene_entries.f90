module bw_scene_entries
  !! The items of a statement as the value of one row of the table: kind, count and range.
  use bw_input_name, only: accepted_text, has_word, in_range, input_name, integer_input, logical_input, reals_input, &
                           text_input
  use bw_input_values, only: input_value
  use bw_kinds, only: dp
  use bw_scene_characters, only: shown
  use bw_scene_items, only: item
  use bw_scene_messages, only: message_list
  use bw_scene_numbers, only: parse_real, parse_whole
  use bw_text, only: lower
  implicit none (type, external)
  private
  public :: read_value, place_of

contains

  pure function place_of(row) result(place)
    !! `group%name`, as messages and sweeps call it.
    type(input_name), intent(in) :: row
    character(:), allocatable :: place
    place = trim(row%group)//'%'//trim(row%name)
  end function place_of

  pure subroutine read_value(row, text, items, value, messages)
    !! Set the value, known when it is right; report what is wrong with it.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: text
    type(item), intent(in) :: items(:)           !! at least one
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    integer :: before
    before = messages%count
    if (row%kind == reals_input) then
      call read_reals(row, text, items, value, messages)
    else if (size(items) > 1 .or. items(1)%repeat > 1) then
      call messages%add(items(min(2, size(items)))%line, place_of(row), &
                        'has more than one value; accepted: '//accepted_text(row))
    else
      call read_scalar(row, text(items(1)%first:items(1)%last), items(1), value, messages)
    end if
    value%known = messages%count == before
  end subroutine read_value

  pure subroutine read_scalar(row, piece, source, value, messages)
    type(input_name), intent(in) :: row
    character(*), intent(in) :: piece
    type(item), intent(in) :: source
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    select case (row%kind)
    case (text_input)
      call read_text(row, piece, source, value, messages)
    case (logical_input)
      call read_logical(row, piece, source, value, messages)
    case default
      call read_number(row, piece, source, value%number, messages)
    end select
  end subroutine read_scalar

  pure subroutine read_number(row, piece, source, number, messages)
    !! A real or a whole number within the row's range.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: piece
    type(item), intent(in) :: source
    real(dp), intent(out) :: number
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: problem
    if (source%quote /= ' ') then
      problem = shown(piece)//' is a text'
      number = 0.0_dp
    else if (row%kind == integer_input) then
      call parse_whole(piece, number, problem)
    else
      call parse_real(piece, number, problem)
    end if
    if (problem /= '') then
      if (index(problem, 'accepted') == 0) problem = problem//'; accepted: '//accepted_text(row)
      call messages%add(source%line, place_of(row), problem)
    else if (.not. in_range(row%range, number)) then
      call messages%add(source%line, place_of(row), shown(piece)//' is out of range; accepted: '//accepted_text(row))
    end if
  end subroutine read_number

  pure subroutine read_reals(row, text, items, value, messages)
    type(input_name), intent(in) :: row
    character(*), intent(in) :: text
    type(item), intent(in) :: items(:)
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    real(dp) :: number
    integer :: i, n
    if (sum(real(items%repeat, dp)) > row%most) then
      call messages%add(items(1)%line, place_of(row), 'has too many values; accepted: '//accepted_text(row))
      return
    end if
    n = sum(items%repeat)
    allocate (value%numbers(n), value%lines(n))
    n = 0
    do i = 1, size(items)
      call read_number(row, text(items(i)%first:items(i)%last), items(i), number, messages)
      value%numbers(n + 1:n + items(i)%repeat) = number
      value%lines(n + 1:n + items(i)%repeat) = items(i)%line
      n = n + items(i)%repeat
    end do
  end subroutine read_reals

  pure subroutine read_text(row, piece, source, value, messages)
    !! A text in quotes, its trailing blanks dropped as Fortran writes them; one of the row's words, if it has
    !! any, in any case.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: piece
    type(item), intent(in) :: source
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    if (source%quote == ' ') then
      call messages%add(source%line, place_of(row), &
                        shown(piece)//' stands without quotes; accepted: '//accepted_text(row))
      return
    end if
    value%text = trim(single_quotes(piece, source%quote))
    if (row%words == '') return
    value%text = lower(value%text)
    if (.not. has_word(row%words, value%text) .or. scan(value%text, ' ') > 0 .or. value%text == '') then
      call messages%add(source%line, place_of(row), shown(piece)//' is not known; accepted: '//accepted_text(row))
    end if
  end subroutine read_text

  pure function single_quotes(piece, quote) result(text)
    !! Undo the doubling of quotes.
    character(*), intent(in) :: piece
    character, intent(in) :: quote
    character(:), allocatable :: text
    integer :: at, n
    allocate (character(len(piece)) :: text)
    at = 1
    n = 0
    do while (at <= len(piece))
      n = n + 1
      text(n:n) = piece(at:at)
      at = at + merge(2, 1, piece(at:at) == quote)
    end do
    text = text(:n)
  end function single_quotes

  pure subroutine read_logical(row, piece, source, value, messages)
    !! `.true.`, `true`, `.t.`, `t` and their opposites in any case; Fortran would take any word in T or F.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: piece
    type(item), intent(in) :: source
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    character(7) :: word
    word = lower(piece)
    if (len(piece) > len(word) .or. source%quote /= ' ') word = ''
    select case (word)
    case ('.true.', 'true', '.t.', 't')
      value%flag = .true.
    case ('.false.', 'false', '.f.', 'f')
      value%flag = .false.
    case default
      call messages%add(source%line, place_of(row), shown(piece)//' is no logical; accepted: '//accepted_text(row))
    end select
  end subroutine read_logical

end module bw_scene_entries
