module bw_word_file
  !! Files of words of eight bytes, and sums that tell whether words are still what they were.
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
  use bw_descriptor, only: bytes_in_file, read_bytes_at, write_bytes
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: write_words, words_in_file, read_words, as_words, checksum

  integer(i8), parameter :: word = 8          !! bytes
  integer, parameter :: stretch = 251
    !! words: not a part of a page, so that pages that change places change the sum; odd, so that equal words do not cancel

contains

  logical function write_words(descriptor, words) result(written)
    !! Write to an open descriptor, at once and whole: what is written survives the process.
    integer, intent(in) :: descriptor           !! of `new_file`
    integer(i8), intent(in), contiguous, target :: words(:)
    written = write_bytes(descriptor, c_loc(words), word*size(words, kind=i8))
  end function write_words

  integer(i8) function words_in_file(descriptor) result(words)
    !! How many whole words it has by now; 0 where the system does not say.
    integer, intent(in) :: descriptor           !! of `open_to_read`
    words = bytes_in_file(descriptor)/word
  end function words_in_file

  logical function read_words(descriptor, position, words) result(done)
    !! Read from any place. False where the system refuses it, or the file ends before.
    integer, intent(in) :: descriptor           !! of `open_to_read`
    integer(i8), intent(in) :: position         !! of the first word, from 1
    integer(i8), intent(out), contiguous, target :: words(:)
    done = read_bytes_at(descriptor, word*(position - 1), c_loc(words), word*size(words, kind=i8))
  end function read_words

  function as_words(numbers) result(words)
    !! The same bits, in their place.
    real(dp), intent(in), contiguous, target :: numbers(:)
    integer(i8), pointer, contiguous :: words(:)
    call c_f_pointer(c_loc(numbers), words, shape(numbers))
  end function as_words

  pure integer(i8) function checksum(words) result(total)
    !! A word that every change of one word changes, and nearly every change of more: the parities of stretches, each stirred
    !! as often as its place says. As quick as the memory.
    integer(i8), intent(in), contiguous :: words(:)
    integer(i8) :: first
    total = 0
    do first = 1, size(words, kind=i8), stretch
      total = ieor(stirred(total), iparity(words(first:min(first + stretch - 1, size(words, kind=i8)))))
    end do
  end function checksum

  pure integer(i8) function stirred(word)
    !! Another word, which comes back to the first after 2⁶⁴ − 1 steps only (G. Marsaglia's xorshift, 2003): pages of equal
    !! numbers, as fill, that are lost cannot cancel, however many they are.
    integer(i8), intent(in) :: word
    stirred = ieor(word, ishft(word, 13))
    stirred = ieor(stirred, ishft(stirred, -7))
    stirred = ieor(stirred, ishft(stirred, 17))
  end function stirred

end module bw_word_file
