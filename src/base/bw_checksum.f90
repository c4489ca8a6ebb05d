module bw_checksum
  !! Sums that tell whether words of eight bytes are still what they were, and where they were. Before each word the sum is
  !! stirred, a step that comes back after 2⁶⁴ − 1 steps only: so a change of one word always changes the sum, and so do two
  !! different words that change places, however far apart; of anything else one in 2⁶⁴ goes unseen.
  use bw_kinds, only: i8
  implicit none (type, external)
  private
  public :: word_sum, lane_sums

  integer, parameter, public :: lanes = 16     !! sums that go on side by side; tuned

contains

  pure integer(i8) function word_sum(words) result(total)
    !! One sum of all words.
    integer(i8), intent(in) :: words(:)
    integer(i8) :: i
    total = 0
    do i = 1, size(words, kind=i8)
      total = ieor(stirred(total), words(i))
    end do
  end function word_sum

  pure function lane_sums(words) result(totals)
    !! A sum of each sixteenth word, from the first, the second, …: as quick as the memory.
    integer(i8), intent(in), contiguous :: words(:)
    integer(i8) :: totals(lanes)
    integer(i8) :: running(lanes), first
    integer :: lane, left
    running = 0
    do first = 1, size(words, kind=i8) - lanes + 1, lanes
      do lane = 1, lanes
        running(lane) = ieor(stirred(running(lane)), words(first + lane - 1))
      end do
    end do
    left = int(mod(size(words, kind=i8), int(lanes, i8)))
    do lane = 1, left
      running(lane) = ieor(stirred(running(lane)), words(size(words, kind=i8) - left + lane))
    end do
    totals = running
  end function lane_sums

  elemental integer(i8) function stirred(word)
    !! The next of all 2⁶⁴ − 1 words that are not zero (G. Marsaglia's xorshift, 2003). It is linear: a difference stays one.
    integer(i8), intent(in) :: word
    stirred = ieor(word, ishft(word, 13))
    stirred = ieor(stirred, ishft(stirred, -7))
    stirred = ieor(stirred, ishft(stirred, 17))
  end function stirred

end module bw_checksum
