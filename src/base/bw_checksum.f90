module bw_checksum
  !! Checksums of words of eight bytes that depend on their order. Before each word the sum passes a mixing step of
  !! period 2⁶⁴ − 1. A change of one word always changes the sum, and so does any exchange of two different words; other
  !! changes are missed with probability 2⁻⁶⁴.
  use bw_kinds, only: i8
  implicit none (type, external)
  private
  public :: word_sum, lane_sums

  integer, parameter, public :: lanes = 16     !! independent sums computed in parallel; tuned

contains

  pure integer(i8) function word_sum(words) result(total)
    !! Return the checksum of all words.
    integer(i8), intent(in) :: words(:)
    integer(i8) :: i
    total = 0
    do i = 1, size(words, kind=i8)
      total = ieor(stirred(total), words(i))
    end do
  end function word_sum

  pure function lane_sums(words) result(totals)
    !! Return sums over every sixteenth word, from the first, the second, …, at the speed of memory.
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
    !! Return the next of all 2⁶⁴ − 1 non-zero words (G. Marsaglia's xorshift, 2003), a linear step that keeps differences.
    integer(i8), intent(in) :: word
    stirred = ieor(word, ishft(word, 13))
    stirred = ieor(stirred, ishft(stirred, -7))
    stirred = ieor(stirred, ishft(stirred, 17))
  end function stirred

end module bw_checksum
