module bw_scene_scalars
  !! A word or a text of the scene as a number, a logical or a text. Fortran's own `read` accepts 1.0-3, 1e999, NaN and 1/2
  !! as numbers; here the form is that of numbers in tables, and numbers outside the range of double precision are rejected.
  !! Every procedure returns in `problem` what is wrong with the word; empty if nothing is.
  use bw_input_name, only: has_word
  use bw_kinds, only: dp, i1, qp
  use bw_number_scan, only: largest_power, scan_number
  use bw_scene_messages, only: shown
  use bw_text, only: lower, text_of
  implicit none (type, external)
  private
  public :: parse_logical, parse_real, parse_text, parse_whole

  character(*), parameter :: digits = '0123456789'
  character(*), parameter :: does_not_fit = ' does not fit into double precision; accepted: sizes of 5e-324 to 1.79e308'
  integer, parameter :: most_whole_digits = 15   !! exact in double precision
  integer, parameter :: most_letters = 1100      !! the longest decimal of a number in double precision has 1075 digits

contains

  pure subroutine parse_real(word, value, problem)
    !! Parse a real: `1`, `-.5`, `1.`, `2e11`, `2d+11`.
    character(*), intent(in) :: word
    real(dp), intent(out) :: value
    character(:), allocatable, intent(out) :: problem
    real(qp) :: wide
    integer :: behind, decade, power
    logical :: fits, good
    value = 0.0_dp
    problem = ''
    if (len(word) > most_letters) then
      problem = shown(word)//' is longer than the '//text_of(most_letters)//' letters of any number'
      return
    end if
    behind = 1
    call scan_number(transfer(word, [0_i1], len(word)), behind, len(word), iachar('.', i1), value, decade, power, good)
    if (behind <= len(word) .or. .not. (good .or. power > largest_power)) then
      problem = shown(word)//' is not a number'//hint(word)
      return
    end if
    fits = value /= 0.0_dp .or. power >= 0
    if (power > largest_power) then
      wide = 0.0_qp
      fits = power == largest_power + 1          ! which holds the largest number
      if (fits) read (word, *) wide
      fits = fits .and. abs(wide) <= huge(value)
      if (fits) read (word, *) value
    end if
    if (.not. fits) problem = shown(word)//does_not_fit
  end subroutine parse_real

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
