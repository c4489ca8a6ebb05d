module scene_mutations
  !! Texts of scenes, damaged at random.
  use random_streams, only: random_stream
  implicit none (type, external)
  private
  public :: damaged

  character, parameter :: nl = new_line('a'), tab = achar(9), carriage_return = achar(13)
  character(*), parameter :: blanks = ' '//nl//tab
  character(*), parameter :: nasty_bytes = "&/=,*'""!;%():.+-eEdD0123456789tTfFnN_ "// &
    tab//nl//carriage_return//achar(0)//char(194)//char(160)//char(255)
  character(*), parameter :: nasty_tokens(*) = [character(25) :: '1/2', '1.0-3', '1e999', '-1e-320', 'NaN', '-Inf', &
    '2*', '0*1', '2*0.5', '3*,', ',,', ';', '= =', '&end', '$end', '/', '!', '&rotatoin', '&sweep', '&capture /', &
    '&modes', '&body', '&support', '&scene', '& beam', 'beam%length = 1', 'points(1) = 0.5', 'length', 'length =', 'samples = 64', &
    'before = 9', 'count = 1000000', 'plane', 'title =', "'", '"', "''", "'impact%mass'", "'body(2)%mass'", &
    "'beam%length(1)'", '0.3, 0.7', "'in'", '.true.', 'Tuesday', 't', '.f', '1d0', '+.5', '1.', '007', '1_8', '1q2', &
    '0x1F', '(1.0, 2.0)', '99999999999', '4294967297', '-0.0', '4.9e-324', '179769313486231580793e289', 'e5', '1.5', &
    "spacing = 'log'", '1,5', tab, carriage_return//nl, &
    char(239)//char(187)//char(191), char(195)//char(188), char(195), achar(0), achar(11), char(194)//char(160)]

contains

  function damaged(text, other, random) result(bad)
    !! A text with one to four random changes.
    character(*), intent(in) :: text
    character(*), intent(in) :: other               !! another scene, of which lines are borrowed
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: bad
    integer :: i, changes
    bad = text
    changes = 1 + random%below(4)*random%below(2)
    do i = 1, changes
      bad = changed(bad, other, random)
      if (len(bad) == 0) bad = ' '
    end do
  end function damaged

  function changed(text, other, random) result(bad)
    character(*), intent(in) :: text, other
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: bad
    select case (random%below(6))
    case (0, 1); bad = bytes_changed(text, random)
    case (2); bad = token_inserted(text, random)
    case (3); bad = tokens_swapped(text, random)
    case (4); bad = number_edited(text, random)
    case default; bad = lines_spliced(text, other, random)
    end select
  end function changed

  function bytes_changed(text, random) result(bad)
    !! Insert, drop, replace or flip a byte; repeat, move or drop a short piece; cut the text.
    character(*), intent(in) :: text
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: bad
    integer :: at, last, c, bit
    at = 1 + random%below(len(text))
    last = min(len(text), at - 1 + random%below(12))
    c = 1 + random%below(len(nasty_bytes))
    select case (random%below(9))
    case (0, 1)
      bad = text(:at - 1)//nasty_bytes(c:c)//text(at:)
    case (2)
      bad = text(:at - 1)//text(at + 1:)
    case (3)
      bad = text(:at - 1)//nasty_bytes(c:c)//text(at + 1:)
    case (4)
      bit = random%below(8)
      bad = text(:at - 1)//char(ieor(ichar(text(at:at)), 2**bit))//text(at + 1:)
    case (5)
      bad = text(:last)//text(at:last)//text(last + 1:)
    case (6)
      bad = text(at:last)//text(:at - 1)//text(last + 1:)
    case (7)
      bad = text(:at - 1)//text(last + 1:)
    case default
      bad = text
      if (random%chance(20)) bad = text(:at - 1)
    end select
  end function bytes_changed

  function token_inserted(text, random) result(bad)
    !! Put one of the nasty tokens between two bytes, with blanks around it or without, or in place of a word.
    character(*), intent(in) :: text
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: bad, piece
    integer :: at, first, last
    piece = trim(nasty_tokens(1 + random%below(size(nasty_tokens))))
    call pick_word(text, random, first, last)
    at = 1 + random%below(len(text))
    select case (random%below(4))
    case (0); bad = text(:first - 1)//piece//text(last + 1:)
    case (1); bad = text(:last)//' '//piece//text(last + 1:)
    case (2); bad = text(:at - 1)//' '//piece//' '//text(at:)
    case default; bad = text(:at - 1)//piece//text(at:)
    end select
  end function token_inserted

  function tokens_swapped(text, random) result(bad)
    !! Let two words change places, or double one.
    character(*), intent(in) :: text
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: bad
    integer :: first(2), last(2), other_first, other_last
    call pick_word(text, random, first(1), last(1))
    call pick_word(text, random, first(2), last(2))
    if (first(1) == first(2)) then
      bad = text(:last(1))//' '//text(first(1):)
      return
    end if
    other_first = maxval(first)
    other_last = maxval(last)
    first(1) = minval(first)
    last(1) = minval(last)
    bad = text(:first(1) - 1)//text(other_first:other_last)//text(last(1) + 1:other_first - 1)// &
          text(first(1):last(1))//text(other_last + 1:)
  end function tokens_swapped

  function number_edited(text, random) result(bad)
    !! Give a number another digit, sign, point or exponent, or turn it into two.
    character(*), intent(in) :: text
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: bad
    character(*), parameter :: edits(*) = [character(9) :: '0', '9', '-', '+', '.', 'e', 'e3', 'E+2', 'd-3', 'D0', &
      'q1', '-3', '*', '2*', ',', ' ', ' ,', '_8', 'e400', 'e-400', '000000000', '/', ' /', '!', '1.0']
    integer :: at, start
    start = 1 + random%below(len(text))
    at = start - 1 + scan(text(start:), '0123456789')
    if (at < start) at = scan(text, '0123456789')
    bad = text
    if (at == 0) return
    associate (edit => edits(1 + random%below(size(edits))))
      select case (random%below(3))
      case (0); bad = text(:at - 1)//edit(:max(1, len_trim(edit)))//text(at + 1:)
      case (1); bad = text(:at - 1)//edit(:max(1, len_trim(edit)))//text(at:)
      case default; bad = text(:at)//edit(:max(1, len_trim(edit)))//text(at + 1:)
      end select
    end associate
  end function number_edited

  function lines_spliced(text, other, random) result(bad)
    !! Drop, double or move a line, join it with the next, or bring one from another scene.
    character(*), intent(in) :: text, other
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: bad, line
    integer :: first, last, to, to_last
    call pick_line(text, random, first, last)
    call pick_line(text, random, to, to_last)
    line = text(first:last)
    select case (random%below(5))
    case (0)
      bad = text(:first - 1)//text(last + 1:)
    case (1)
      bad = text(:to - 1)//line//text(to:)
    case (2)
      if (to <= last) then
        bad = text(:to - 1)//line//text(to:first - 1)//text(last + 1:)
      else
        bad = text(:first - 1)//text(last + 1:to - 1)//line//text(to:)
      end if
    case (3)
      bad = text(:last - 1)//text(last + 1:)
    case default
      call pick_line(other, random, first, last)
      bad = text(:to - 1)//other(first:last)//text(to:)
    end select
  end function lines_spliced

  subroutine pick_word(text, random, first, last)
    !! A random word between blanks; empty where there is none behind the place that was drawn.
    character(*), intent(in) :: text
    type(random_stream), intent(inout) :: random
    integer, intent(out) :: first, last
    integer :: length
    first = 1 + random%below(len(text))
    length = verify(text(first:), blanks)
    last = first - 1
    if (length == 0) return
    first = first + length - 1
    do while (first > 1)
      if (scan(text(first - 1:first - 1), blanks) > 0) exit
      first = first - 1
    end do
    length = scan(text(first:), blanks)
    last = merge(len(text), first + length - 2, length == 0)
  end subroutine pick_word

  subroutine pick_line(text, random, first, last)
    !! A random line with its end.
    character(*), intent(in) :: text
    type(random_stream), intent(inout) :: random
    integer, intent(out) :: first, last
    integer :: at
    at = 1 + random%below(len(text))
    first = index(text(:at - 1), nl, back=.true.) + 1
    last = index(text(at:), nl)
    last = merge(len(text), at + last - 1, last == 0)
  end subroutine pick_line

end module scene_mutations
