module bw_scene_entries
  !! The items of a statement as the value of one row of the table of names, with its kind, count and range.
  use bw_input_name, only: accepted_text, columns_input, in_range, input_name, integer_input, is_list, is_number, &
                           logical_input, place_of, reals_input, text_input, texts_input
  use bw_input_values, only: input_value
  use bw_kinds, only: dp
  use bw_scene_items, only: item
  use bw_scene_messages, only: message_list, shown
  use bw_scene_scalars, only: parse_logical, parse_real, parse_text, parse_whole
  use bw_text, only: text_of
  use bw_value_hints, only: value_hint
  implicit none (type, external)
  private
  public :: read_value

contains

  pure subroutine read_value(row, text, items, value, messages)
    !! Set the value, known if it is valid; report what is wrong with it.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: text
    type(item), intent(in) :: items(:)           !! at least one
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: hint
    logical :: several
    integer :: before
    before = messages%count
    several = size(items) > 1 .or. items(1)%repeat > 1
    hint = hint_of_items(row, text, items)
    if (several .and. (.not. is_list(row) .or. hint /= '')) then
      call messages%add(items(min(2, size(items)))%line, place_of(row), &
                        'has more than one value'//hint//'; accepted: '//accepted_text(row)//list_hint(row, hint))
    else if (row%kind == reals_input) then
      call read_reals(row, text, items, value, messages)
    else if (row%kind == texts_input .or. row%kind == columns_input) then
      call read_texts(row, text, items, value, messages)
    else
      call read_scalar(row, text(items(1)%first:items(1)%last), items(1), value, messages)
    end if
    value%known = messages%count == before
  end subroutine read_value

  pure function hint_of_items(row, text, items) result(hint)
    !! Suggest what several values may mean if one is accepted, or one for each piece.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: text
    type(item), intent(in) :: items(:)
    character(:), allocatable :: hint
    hint = ''
    if (.not. (is_number(row) .or. row%along /= '')) return
    if (row%kind == integer_input .and. size(items) == 2) then
      if (items(2)%last - items(2)%first /= 2) return   ! thousands have three digits
    end if
    associate (written => text(items(1)%first:items(size(items))%last))
      if (items(1)%repeat > 1) then
        hint = value_hint(text_of(items(1)%repeat)//'*'//written, row%unit)
      else
        hint = value_hint(written, row%unit)
      end if
    end associate
  end function hint_of_items

  pure function list_hint(row, hint) result(text)
    !! Explain how to separate the values of two pieces, if they look like a decimal comma.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: hint             !! of `hint_of_items`
    character(:), allocatable :: text
    text = ''
    if (row%along /= '' .and. index(hint, '; a comma') == 1) text = ', with a blank behind each comma'
  end function list_hint

  pure subroutine read_scalar(row, piece, source, value, messages)
    !! Read a number, a logical or a text.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: piece
    type(item), intent(in) :: source
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: problem
    real(dp) :: number
    select case (row%kind)
    case (text_input)
      call parse_text(piece, source%quote, row%words, value%text, problem)
    case (logical_input)
      call parse_logical(piece, source%quote, value%flag, problem)
    case default
      call read_number(row, piece, source, number, messages)
      call value%set_numbers([number], source%line)
      return
    end select
    if (problem /= '') call messages%add(source%line, place_of(row), problem//'; accepted: '//accepted_text(row))
  end subroutine read_scalar

  pure subroutine read_number(row, piece, source, number, messages, pair)
    !! Read a real or a whole number within the row's range.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: piece
    type(item), intent(in) :: source
    real(dp), intent(out) :: number
    type(message_list), intent(inout) :: messages
    character(*), intent(in), optional :: pair   !! in a list, this word with the one before it
    character(:), allocatable :: problem
    if (source%quote /= ' ') then
      problem = shown(piece)//' is a text'
      number = 0.0_dp
    else if (row%kind == integer_input) then
      call parse_whole(piece, number, problem)
    else
      call parse_real(piece, number, problem)
    end if
    if (problem /= '' .and. source%quote == ' ') problem = problem//value_hint(piece, row%unit)
    if (problem /= '') then
      if (index(problem, 'accepted') == 0) problem = problem//'; accepted: '//accepted_text(row)
      call messages%add(source%line, place_of(row), problem)
    else if (.not. in_range(row%range, number)) then
      call messages%add(source%line, place_of(row), shown(piece)//' is out of range; accepted: '//accepted_text(row)// &
                        place_hint(row, pair))
    end if
  end subroutine read_number

  pure logical function has_decimal_commas(text, items) result(has)
    !! Return whether items are pairs of whole numbers, each joined by a comma alone, with blanks between pairs: `0,5 1,0`.
    character(*), intent(in) :: text
    type(item), intent(in) :: items(:)
    integer :: i
    has = .false.
    if (size(items) < 4 .or. mod(size(items), 2) == 1) return
    do i = 2, size(items)
      associate (gap => text(items(i - 1)%last + 1:items(i)%first - 1))
        if (mod(i, 2) == 0 .and. gap /= ',') return
        if (mod(i, 2) == 1 .and. index(gap, ',') > 0) return
      end associate
      if (mod(i, 2) == 1) cycle
      if (value_hint(text(items(i - 1)%first:items(i)%last), '') == '') return
    end do
    has = .true.
  end function has_decimal_commas

  pure function place_hint(row, pair) result(hint)
    !! Suggest a correction for a place along the beam given in metres or with a decimal comma.
    type(input_name), intent(in) :: row
    character(*), intent(in), optional :: pair   !! as in `read_number`
    character(:), allocatable :: hint
    hint = ''
    if (present(pair)) hint = value_hint(pair, '')
    if (hint == '' .and. (row%name == 'points' .or. row%name == 'position')) &
      hint = '; places are xi = x/l, from 0 at the root to 1 at the tip, and not in metres'
  end function place_hint

  pure subroutine read_reals(row, text, items, value, messages)
    !! Read a list of reals, each repeated as its item says.
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
    if (has_decimal_commas(text, items)) then
      call messages%add(items(1)%line, place_of(row), shown(text(items(1)%first:items(2)%last))// &
                        ' may be one number or two'//value_hint(text(items(1)%first:items(2)%last), '')// &
                        '; accepted: a blank behind each comma that separates')
      return
    end if
    n = sum(items%repeat)
    allocate (value%numbers(n), value%lines(n), value%sweeps(n))
    value%sweeps = 0
    n = 0
    do i = 1, size(items)
      call read_number(row, text(items(i)%first:items(i)%last), items(i), number, messages, &
                       text(items(max(1, i - 1))%first:items(i)%last))
      value%numbers(n + 1:n + items(i)%repeat) = number
      value%lines(n + 1:n + items(i)%repeat) = items(i)%line
      n = n + items(i)%repeat
    end do
  end subroutine read_reals

  pure subroutine read_texts(row, text, items, value, messages)
    !! Read a list of texts, or of columns by name or number, each repeated as its item says.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: text
    type(item), intent(in) :: items(:)
    type(input_value), intent(inout) :: value
    type(message_list), intent(inout) :: messages
    integer :: i, j, n
    if (sum(real(items%repeat, dp)) > row%most) then
      call messages%add(items(1)%line, place_of(row), 'has too many values; accepted: '//accepted_text(row))
      return
    end if
    n = sum(items%repeat)
    allocate (value%texts(n))
    call value%set_numbers([(0.0_dp, i=1, n)], items(1)%line)
    n = 0
    do i = 1, size(items)
      do j = 1, items(i)%repeat
        n = n + 1
        value%lines(n) = items(i)%line
        call read_one_text(row, text(items(i)%first:items(i)%last), items(i), value%texts(n)%text, value%numbers(n), &
                           messages)
      end do
    end do
  end subroutine read_texts

  pure subroutine read_one_text(row, piece, source, text, number, messages)
    !! Read one text of a list, or a column: a number without quotes is the number of a column.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: piece
    type(item), intent(in) :: source
    character(:), allocatable, intent(out) :: text
    real(dp), intent(inout) :: number
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: problem
    text = ''
    if (row%kind == columns_input .and. source%quote == ' ') then
      call parse_whole(piece, number, problem)
      if (problem == '' .and. .not. in_range(row%range, number)) problem = shown(piece)//' is out of range'
    else
      call parse_text(piece, source%quote, row%words, text, problem)
      if (problem == '' .and. text == '') problem = 'is empty'
    end if
    if (problem /= '') call messages%add(source%line, place_of(row), problem//'; accepted: '//accepted_text(row))
  end subroutine read_one_text

end module bw_scene_entries
