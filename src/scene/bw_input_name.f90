module bw_input_name
  !! One row of the table of input names, and the group that it belongs to.
  !!
  !! A row holds everything about a name: the reader, its messages, `beamwave describe`, the resolved scene and the
  !! input variables of the result all use it. Texts have fixed lengths, so that the table is a constant.
  use bw_kinds, only: dp, i8
  use bw_text, only: replaced, text_of
  implicit none (type, external)
  private
  public :: accepted_text, has_numbers, has_unit, has_word, in_range, is_list, is_number, is_simulated, is_sweepable, &
    kind_text, place_of, quoted_words, range_text

  integer, parameter, public :: name_length = 24
  integer, parameter, public :: real_input = 1, integer_input = 2, logical_input = 3, text_input = 4, reals_input = 5, &
                                texts_input = 6, columns_input = 7      !! column names in quotes, or numbers from 1

  type, public :: number_range
    !! The numbers that a name accepts: low … high, both included unless `above` is true.
    real(dp) :: low = -huge(1.0_dp)
    real(dp) :: high = huge(1.0_dp)
    logical :: above = .false.               !! `low` itself is not accepted
  end type number_range

  type(number_range), parameter, public :: any_number = number_range()
  type(number_range), parameter, public :: positive = number_range(low=0.0_dp, above=.true.)
  type(number_range), parameter, public :: not_negative = number_range(low=0.0_dp)
  type(number_range), parameter, public :: unit_interval = number_range(low=0.0_dp, high=1.0_dp)
  type(number_range), parameter, public :: off_the_root = number_range(low=0.0_dp, high=1.0_dp, above=.true.)   !! ξ

  type, public :: input_group
    !! A namelist group.
    character(name_length) :: name = ''
    character(120) :: absent = ''            !! what its absence means
    character(480) :: physics = ''           !! what it models, in a sentence or two
    character(480) :: example = ''           !! its use in a scene, `|` between lines; the beam may be left out
    character(1000) :: rules = ''            !! rules between its names
    character(48) :: needs = ''              !! groups that it requires, separated by blanks; `a|b`: one of the two
    character(48) :: excludes = ''           !! groups that it replaces, separated by blanks
    logical :: required = .false.
    character(name_length) :: unless = ''    !! a group with which a required one may be absent
    logical :: implied = .false.             !! an absent group is treated as an empty one
    logical :: repeatable = .false.
    character(8) :: along = ''               !! dimension along which its repeats lie in a result; '': none
    logical :: is_effect = .false.           !! it changes the beam or its free motion
    logical :: is_event = .false.            !! it occurs at an instant; results list events, too, in their attribute `effects`
    logical :: builds_up = .false.           !! it changes the boundary conditions or attaches something
    logical :: changes_shapes = .false.      !! modes of a beam with it have no closed form
  end type input_group

  type, public :: input_name
    !! A name in a group.
    character(name_length) :: group = ''
    character(name_length) :: name = ''
    integer :: kind = real_input             !! one of the kinds above
    character(12) :: unit = '1'              !! as UDUNITS writes it; '' if another name gives it
    type(number_range) :: range = any_number !! of each number
    character(24) :: default = ''            !! as a scene would write it; '' for none
    logical :: required = .false.
    character(40) :: unless = ''             !! names of the group, by blanks; a required name may be absent with any of them
    logical :: swept = .false.               !! `&sweep` may vary it: a number that sets no axis of the result
    integer :: most = 1                      !! largest number of elements
    character(8) :: along = ''               !! dimension of a result along which the numbers of a list lie
    character(80) :: words = ''              !! accepted words of a text, separated by blanks; '': any text
    character(72) :: excludes = ''           !! names of the same group that it replaces, separated by blanks
    character(80) :: meaning = ''
    logical :: changes_shapes = .false.      !! modes have no closed form unless the number is `plain`
    real(dp) :: plain = 0.0_dp
  end type input_name

contains

  elemental logical function is_simulated(group)
    !! Return whether the group is an effect or an event.
    type(input_group), intent(in) :: group
    is_simulated = group%is_effect .or. group%is_event
  end function is_simulated

  elemental logical function in_range(range, value)
    !! Return whether the range accepts a value.
    type(number_range), intent(in) :: range
    real(dp), intent(in) :: value
    in_range = value >= range%low .and. value <= range%high .and. .not. (range%above .and. value == range%low)
  end function in_range

  elemental logical function is_number(row)
    !! Return whether the name takes one number, real or whole.
    type(input_name), intent(in) :: row
    is_number = row%kind == real_input .or. row%kind == integer_input
  end function is_number

  elemental logical function is_list(row)
    !! Return whether the name takes several values.
    type(input_name), intent(in) :: row
    is_list = row%most > 1
  end function is_list

  elemental logical function has_unit(row)
    !! Return whether the name takes numbers with a unit of their own.
    type(input_name), intent(in) :: row
    has_unit = row%unit /= '' .and. has_numbers(row)
  end function has_unit

  elemental logical function has_numbers(row)
    !! Return whether the name takes numbers, one or several.
    type(input_name), intent(in) :: row
    has_numbers = is_number(row) .or. row%kind == reals_input
  end function has_numbers

  elemental logical function is_sweepable(row)
    !! Return whether a `&sweep` may vary the name or, of a list, one of its numbers.
    type(input_name), intent(in) :: row
    is_sweepable = row%swept .and. has_numbers(row)
  end function is_sweepable

  pure function place_of(row) result(place)
    !! Return `group%name`, as messages and sweeps call it.
    type(input_name), intent(in) :: row
    character(:), allocatable :: place
    place = trim(row%group)//'%'//trim(row%name)
  end function place_of

  pure function kind_text(row) result(text)
    !! Return the kind in words: `real`, `whole number`, `logical`, `text`, `reals`, `real or list`.
    type(input_name), intent(in) :: row
    character(:), allocatable :: text
    character(16), parameter :: names(*) = [character(16) :: 'real', 'whole number', 'logical', 'text', 'reals', &
                                            'text or list', 'name or number']
    text = trim(names(row%kind))
    if (row%kind == reals_input .and. row%along /= '') text = 'real or list'
    if (row%kind == columns_input .and. is_list(row)) text = 'names, numbers'
  end function kind_text

  pure function range_text(row) result(text)
    !! Return the range as text short enough for a column: `> 0`, `0 to 1`, `any`, `.true., .false.`, `one word`.
    type(input_name), intent(in) :: row
    character(:), allocatable :: text
    logical :: low, high
    low = row%range%low > -huge(1.0_dp)
    high = row%range%high < huge(1.0_dp)
    if (row%kind == logical_input) then
      text = '.true., .false.'
    else if (row%kind == columns_input) then
      text = 'any, or 1 to '//text_of(nint(row%range%high, i8))
    else if (row%kind == text_input .or. row%kind == texts_input) then
      text = merge('a word, below', 'any          ', row%words /= '')
      text = trim(text)
    else if (row%kind == integer_input) then
      text = text_of(nint(row%range%low, i8))//' to '//text_of(nint(row%range%high, i8))
    else if (low .and. high) then
      text = text_of(row%range%low)//' to '//text_of(row%range%high)
      if (row%range%above) text = '> '//text_of(row%range%low)//', up to '//text_of(row%range%high)
    else if (low) then
      text = trim(merge('> ', '>=', row%range%above))//' '//text_of(row%range%low)
    else
      text = 'any'
    end if
  end function range_text

  pure function accepted_text(row) result(text)
    !! Describe in words what a name accepts, for a message: `a real, > 0 (m)`.
    type(input_name), intent(in) :: row
    character(:), allocatable :: text
    select case (row%kind)
    case (logical_input)
      text = '.true. or .false.'
    case (text_input)
      text = 'a text in quotes'
      if (row%words /= '') text = quoted_words(row%words)
    case (texts_input)
      text = 'texts in quotes'
      if (row%words /= '') text = quoted_words(row%words)
      if (row%words /= '' .and. is_list(row)) text = text//', one, or one for each column'
    case (columns_input)
      text = 'the name of a column in quotes, or its number, from 1'
      if (row%most > 1) text = text//'; or several of them'
    case (reals_input)
      text = '1 to '//text_of(row%most)//' reals'
      if (row%along /= '') text = 'a real'
    case default
      text = 'a '//kind_text(row)
    end select
    if (.not. has_numbers(row)) return
    if (range_text(row) /= 'any') text = text//', '//range_text(row)
    if (row%unit /= '1' .and. row%unit /= '') text = text//' ('//trim(row%unit)//')'
    if (row%along /= '') text = text//', or one for each '//trim(row%along)
  end function accepted_text

  pure function quoted_words(words) result(text)
    !! Quote words: `in out` → `'in', 'out'`.
    character(*), intent(in) :: words
    character(:), allocatable :: text
    text = "'"//replaced(trim(words), ' ', "', '")//"'"
  end function quoted_words

  elemental logical function has_word(words, word)
    !! Return whether a list separated by blanks has the word.
    character(*), intent(in) :: words, word
    has_word = index(' '//words//' ', ' '//trim(word)//' ') > 0
  end function has_word

end module bw_input_name
