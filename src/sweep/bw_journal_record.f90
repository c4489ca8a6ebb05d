module bw_journal_record
  !! A record of a journal: a header, the numbers of a case, and its notes, in words of eight bytes.
  use bw_checksum, only: lanes
  use bw_kinds, only: i8
  implicit none (type, external)
  private
  public :: make_room, words_of

  integer, parameter, public :: word = 8                           !! bytes
  integer(i8), parameter, public :: mark = 7311138210646680930_i8  !! 'beamwave' as a word: how every record begins
  integer, parameter, public :: at_work = 2      !! sum of the text of the work that the journal belongs to
  integer, parameter, public :: at_case = 3      !! number of the case; 0: the notes are that text
  integer, parameter, public :: at_count = 4     !! how many numbers
  integer, parameter, public :: at_letters = 5   !! of the notes behind them
  integer, parameter, public :: at_sums = 6      !! sums of numbers and notes, `lanes` of them
  integer, parameter, public :: header = at_sums + lanes           !! words; the last is the sum of those before

contains

  subroutine make_room(words, least, kept)
    !! Room for so many words; of those that are there the first are kept.
    integer(i8), pointer, contiguous, intent(inout) :: words(:)
    integer(i8), intent(in) :: least, kept
    integer(i8), pointer, contiguous :: longer(:)
    if (associated(words)) then
      if (size(words, kind=i8) >= least) return
    end if
    allocate (longer(least + least/8))
    if (associated(words)) then
      longer(:kept) = words(:kept)
      deallocate (words)
    end if
    words => longer
  end subroutine make_room

  pure integer(i8) function words_of(letters)
    !! How many words hold so many letters.
    integer(i8), intent(in) :: letters
    words_of = (letters + word - 1)/word
  end function words_of

end module bw_journal_record
