module bw_journal_writer
  !! The journal of one process: a record for each case of a sweep that it has finished, written at once and whole, so that it
  !! outlives the process, however that ends. Nobody else writes to it, and nobody changes it. It says itself what it belongs
  !! to: its first record is a text, of which each record holds a sum.
  !!
  !! A record is a header, the numbers of a case, and its notes, in words of eight bytes.
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
  use bw_checksum, only: lane_sums, lanes, word_sum, words_of_text
  use bw_descriptors, only: close_file, look_at_open, new_file, open_file, write_words
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: cannot_be_written, look_at, path_state, same_file
  use bw_kinds, only: dp, i8
  use bw_stopwatch, only: wall_seconds
  use bw_text, only: string
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

  real(dp), parameter :: look_every = 0.5_dp                !! s between two looks whether the file is still there

  type, public :: journal_writer
    character(:), allocatable :: path
    character(:), allocatable :: work                       !! whose cases these are
    integer, private :: descriptor = -1
    integer(i8), private :: sum_of_work = 0
    real(dp), private :: looked = 0.0_dp
    integer(i8), pointer, contiguous, private :: record(:) => null()
  contains
    procedure :: prepare
    procedure :: append => append_case
    procedure :: close => close_writer
    procedure, private :: begin
    procedure, private :: write_record
    procedure, private :: look
  end type journal_writer

contains

  subroutine prepare(self, count, numbers, error)
    !! Point to where the numbers of the next case go; the journal begins with its first case.
    !! **Errors**: the journal cannot be made.
    class(journal_writer), intent(inout) :: self
    integer(i8), intent(in) :: count
    real(dp), pointer, contiguous, intent(out) :: numbers(:)  !! (count)
    type(error_type), allocatable, intent(inout) :: error
    call self%begin(error)
    call make_room(self%record, header + count, 0_i8)
    call c_f_pointer(c_loc(self%record(header + 1)), numbers, [count])
  end subroutine prepare

  subroutine begin(self, error)
    !! Make the file and its first record, unless they are there.
    !! **Errors**: they cannot be made.
    class(journal_writer), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    type(string) :: text(1)
    integer :: problem
    if (self%descriptor >= 0) return
    problem = open_file(self%path, new_file, self%descriptor)
    text(1)%text = self%work
    self%sum_of_work = word_sum(words_of_text(self%work))
    if (problem == 0) call self%write_record(0_i8, 0_i8, text, problem)
    if (problem /= 0) call cannot_be_written(error, self%path, problem)
  end subroutine begin

  subroutine append_case(self, case, count, notes, error)
    !! Write a finished case, whose numbers are where `prepare` has shown.
    !! **Errors**: it cannot be written, or the file is gone.
    class(journal_writer), intent(inout) :: self
    integer(i8), intent(in) :: case, count
    type(string), intent(in) :: notes(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: problem
    call self%write_record(case, count, notes, problem)
    if (problem /= 0) call cannot_be_written(error, self%path, problem)
    if (problem == 0) call self%look(error)
  end subroutine append_case

  subroutine write_record(self, case, count, notes, problem)
    !! Write the numbers that are there already, with all that belongs to them.
    class(journal_writer), intent(inout) :: self
    integer(i8), intent(in) :: case, count
    type(string), intent(in) :: notes(:)
    integer, intent(out) :: problem
    character(:), allocatable :: text
    integer(i8) :: last
    integer :: i
    text = ''
    do i = 1, size(notes)
      text = text//notes(i)%text//new_line('a')
    end do
    last = header + count + words_of(len(text, i8))
    call make_room(self%record, last, header + count)
    self%record(header + count + 1:last) = words_of_text(text)
    associate (head => self%record(:header))
      head(:at_letters) = [mark, self%sum_of_work, case, count, len(text, i8)]
      head(at_sums:at_sums + lanes - 1) = lane_sums(self%record(header + 1:last))
      head(header) = word_sum(head(:header - 1))
    end associate
    problem = write_words(self%descriptor, self%record(:last))
  end subroutine write_record

  subroutine look(self, error)
    !! Make sure now and then that the file is still there under its name.
    !! **Errors**: it is gone.
    class(journal_writer), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: mine, named
    real(dp) :: now
    integer :: problem
    now = wall_seconds()
    if (now - self%looked <= look_every) return
    self%looked = now
    problem = look_at_open(self%descriptor, mine)
    if (problem == 0) problem = look_at(self%path, named)
    if (problem == 0 .and. same_file(mine, named)) return
    call fail(error, status_bad_file, self%path// &
              ': is gone: somebody has removed it while cases were done, or its file system is no longer there')
  end subroutine look

  subroutine close_writer(self, error)
    !! Close the journal.
    !! **Errors**: some of what was written could not be kept.
    class(journal_writer), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    integer :: problem
    problem = close_file(self%descriptor)
    if (problem /= 0) call cannot_be_written(error, self%path, problem)
    if (associated(self%record)) deallocate (self%record)
  end subroutine close_writer

  subroutine make_room(words, least, used)
    !! Make room for at least so many words. Of those that are there the first `used` stay as they are.
    integer(i8), pointer, contiguous, intent(inout) :: words(:)
    integer(i8), intent(in) :: least, used
    integer(i8), pointer, contiguous :: longer(:)
    if (associated(words)) then
      if (size(words, kind=i8) >= least) return
    end if
    allocate (longer(least + least/8))
    if (associated(words)) then
      longer(:used) = words(:used)
      deallocate (words)
    end if
    words => longer
  end subroutine make_room

  pure integer(i8) function words_of(letters)
    !! How many words hold so many letters.
    integer(i8), intent(in) :: letters
    words_of = (letters + word - 1)/word
  end function words_of

end module bw_journal_writer
