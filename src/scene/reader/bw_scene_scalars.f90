module bw_scene_scalars
  !! A word or a text of the scene as a number, a logical or a text. Fortran's own `read` accepts 1.0-3, 1e999, NaN and 1/2
  !! as numbers; here the form is checked first, and numbers outside the range of double precision are rejected.
  !! Every procedure returns in `problem` what is wrong with the word; empty if nothing is.
  use bw_input_name, only: has_word
  use bw_kinds, only: dp, qp
  use bw_scene_messages, only: shown
  use bw_text, only: lower, text_of
  implicit none (type, external)
  private
  public :: parse_logical, parse_real, parse_text, parse_whole

  character(*), parameter :: digits = '0123456789'
  character(*), parameter :: does_not_fit = ' does not fit into double precision; accepted: sizes of 5e-324 to 1.79e308'
  integer, parameter :: most_whole_digits = 15   !! exact in double precision
  integer, parameter :: most_letters = 1100      !! the longest decimal of a number in double precision has 1075 digits

  type :: number_form
    !! The places of the parts of [sign] digits [. digits] [letter [sign] digits].
    logical :: good = .false.
    integer :: first = 1                         !! first character of the mantissa
    integer :: point = 0                         !! the point, or where it would be
    integer :: last = 0                          !! last character of the mantissa
    integer :: letter = 0                        !! of the exponent; 0 for none
  end type number_form

contains

  pure subroutine parse_real(word, value, problem)
    !! Parse a real: `1`, `-.5`, `1.`, `2e11`, `2d+11`.
    character(*), intent(in) :: word
    real(dp), intent(out) :: value
    character(:), allocatable, intent(out) :: problem
    type(number_form) :: form
    integer :: decade
    value = 0.0_dp
    problem = ''
    form = form_of(word)
    if (len(word) > most_letters) then
      problem = shown(word)//' is longer than the '//text_of(most_letters)//' letters of any number'
      return
    end if
    if (.not. form%good) then
      problem = shown(word)//' is not a number'//hint(word)
      return
    end if
    if (verify(word(form%first:form%last), '0.') == 0) return
    decade = decade_of(word, form)
    if (decade > 308 .or. decade < -324) then
      problem = shown(word)//does_not_fit
      return
    end if
    call read_real(word, form%letter, abs(decade) > 300, value, problem)
  end subroutine parse_real

  pure subroutine read_real(word, letter, wary, value, problem)
    !! Read a word of valid form; overflow, or rounding to 0, is a problem.
    character(*), intent(in) :: word
    integer, intent(in) :: letter              !! place of the exponent's letter; 0 for none
    logical, intent(in) :: wary                !! read in extended precision first, to detect overflow
    real(dp), intent(inout) :: value
    character(:), allocatable, intent(inout) :: problem
    character(len(word)) :: plain
    real(qp) :: wide
    plain = word
    if (letter > 0) plain(letter:letter) = 'e'
    wide = 1.0_qp
    if (wary) read (plain, *) wide
    if (abs(wide) <= huge(1.0_dp)) read (plain, *) value
    if (value == 0.0_dp) problem = shown(word)//does_not_fit
  end subroutine read_real

  pure subroutine parse_whole(word, value, problem)
    !! Parse a whole number: `20`, `+20`, `-3`; exact in `value`.
    character(*), intent(in) :: word
    real(dp), intent(out) :: value
    character(:), allocatable, intent(out) :: problem
    integer :: first
    value = 0.0_dp
    problem = ''
    first = 1
    if (scan(word(1:min(1, len(word))), '+-') == 1) first = 2
    if (first > len(word) .or. verify(word(first:), digits) > 0) then
      problem = shown(word)//' is not a whole number written with digits alone'
    else if (len(word(first:)) > most_whole_digits) then
      problem = shown(word)//' is too large'
    else
      read (word, *) value
    end if
  end subroutine parse_whole

  pure type(number_form) function form_of(word) result(form)
    !! Find the parts of a number in a word.
    character(*), intent(in) :: word
    integer :: at, count
    at = 1
    if (starts(word, at, '+-')) at = 2
    form%first = at
    at = behind_digits(word, at)
    count = at - form%first
    form%point = at
    if (starts(word, at, '.')) then
      at = behind_digits(word, at + 1)
      count = count + at - form%point - 1
    end if
    form%last = at - 1
    if (count == 0) return
    form%good = at > len(word)
    if (form%good .or. .not. starts(word, at, 'eEdD')) return
    form%letter = at
    at = at + 1
    if (starts(word, at, '+-')) at = at + 1
    form%good = at <= len(word) .and. behind_digits(word, at) > len(word)
  end function form_of

  pure logical function starts(word, at, set)
    !! Tell whether there is a character at `at` that is in the set.
    character(*), intent(in) :: word, set
    integer, intent(in) :: at
    starts = .false.
    if (at <= len(word)) starts = index(set, word(at:at)) > 0
  end function starts

  pure integer function behind_digits(word, at)
    !! Return the place of the first character from `at` on that is not a digit.
    character(*), intent(in) :: word
    integer, intent(in) :: at
    behind_digits = verify(word(at:), digits)
    behind_digits = merge(len(word) + 1, at + behind_digits - 1, behind_digits == 0)
  end function behind_digits

  pure integer function decade_of(word, form)
    !! Return the power of ten of the first nonzero digit.
    character(*), intent(in) :: word
    type(number_form), intent(in) :: form
    integer :: leading
    leading = form%first - 1 + scan(word(form%first:form%last), '123456789')
    decade_of = form%point - leading - merge(1, 0, leading < form%point) + exponent_of(word, form)
  end function decade_of

  pure integer function exponent_of(word, form)
    !! Return the exponent as written, limited to a size that no number in double precision has.
    character(*), intent(in) :: word
    type(number_form), intent(in) :: form
    integer, parameter :: cut = 100000000
    integer :: first
    exponent_of = 0
    if (form%letter == 0) return
    first = form%letter + 1
    if (starts(word, first, '+-')) first = first + 1
    if (verify(word(first:), '0') == 0) return
    first = first - 1 + verify(word(first:), '0')
    if (len(word(first:)) > 8) then
      exponent_of = cut
    else
      read (word(first:), *) exponent_of
    end if
    if (word(form%letter + 1:form%letter + 1) == '-') exponent_of = -exponent_of
  end function exponent_of

  pure function hint(word) result(text)
    !! Suggest what was meant by a word that is not a number.
    character(*), intent(in) :: word
    character(:), allocatable :: text
    integer :: sign
    text = '; accepted: as in 2.5, 7870, 2e11'
    sign = scan(word, '+-', back=.true.)
    if (verify(lower(word), '+-nainfty') == 0) then
      text = '; accepted: finite numbers'
    else if (sign > 1) then
      if (verify(word, digits//'+-.') == 0) text = '; an exponent needs its letter, as in 1.0e-3'
    end if
  end function hint

  pure subroutine parse_text(piece, quote, words, text, problem)
    !! Parse a text in quotes, without trailing blanks, which Fortran's output adds. If words are listed, it must be one of
    !! them, in any case.
    character(*), intent(in) :: piece          !! without its quotes
    character, intent(in) :: quote             !! blank if it has no quotes
    character(*), intent(in) :: words          !! accepted words, separated by blanks; '': any text
    character(:), allocatable, intent(inout) :: text
    character(:), allocatable, intent(out) :: problem
    problem = ''
    if (quote == ' ') then
      problem = shown(piece)//' is not in quotes'
      return
    end if
    text = trim(single_quotes(piece, quote))
    if (words == '') return
    text = lower(text)
    if (.not. has_word(words, text) .or. scan(text, ' ') > 0 .or. text == '') problem = shown(piece)//' is not known'
  end subroutine parse_text

  pure function single_quotes(piece, quote) result(text)
    !! Replace doubled quotes by single ones.
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

  pure subroutine parse_logical(piece, quote, flag, problem)
    !! Parse `.true.`, `true`, `.t.`, `t` and their opposites in any case; Fortran would accept any word that begins with T or F.
    character(*), intent(in) :: piece
    character, intent(in) :: quote             !! blank for a bare word
    logical, intent(inout) :: flag
    character(:), allocatable, intent(out) :: problem
    character(7) :: word
    problem = ''
    word = lower(piece)
    if (len(piece) > len(word) .or. quote /= ' ') word = ''
    select case (word)
    case ('.true.', 'true', '.t.', 't')
      flag = .true.
    case ('.false.', 'false', '.f.', 'f')
      flag = .false.
    case default
      problem = shown(piece)//' is not a logical'
    end select
  end subroutine parse_logical

end module bw_scene_scalars
