module bw_journal_reader
  !! Reading a journal, from record to record. Sums tell whether a record is still what it was; one that is not costs that
  !! record, and reading goes on with the next.
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
  use bw_checksum, only: lane_sums, lanes, word_sum
  use bw_descriptors, only: close_file, is_file, look_at_open, open_file, read_bytes, read_words, to_read_itself
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: path_state, reason
  use bw_journal_writer, only: at_case, at_count, at_letters, at_sums, at_work, header, make_room, mark, word, words_of
  use bw_kinds, only: dp, i1, i8
  use bw_text, only: lines_of, string
  implicit none (type, external)
  private

  integer(i8), parameter :: read_at_once = 32768            !! words: they stay in a cache; tuned
  integer, parameter :: is_sound = 1, is_damaged = 2, is_cut = 3, is_none = 4
    !! what can lie in a place: a record as it was written; one that is not, or none at all; one of which the file lacks the
    !! end; less than could be one

  type, public :: journal_reader
    !! At a record of a journal: `case`, `work`, `numbers` and `notes` are the record's.
    character(:), allocatable :: path
    integer(i8) :: case = 0
    integer(i8) :: work = 0                                 !! sum of the text of the work that it belongs to
    real(dp), pointer, contiguous :: numbers(:) => null()
    type(string), allocatable :: notes(:)
    integer(i8) :: damaged = 0                              !! records so far that are not what they were
    integer, private :: descriptor = -1
    integer(i8), private :: place = 0                       !! of the next record, bytes from 0
    integer(i8), pointer, contiguous, private :: buffer(:) => null()
    integer(i8), private :: origin = 0                      !! place of the buffer's first word
    integer(i8), private :: have = 0                        !! words in the buffer
    integer(i8), private :: at_once = read_at_once          !! words that are read at a time: whole records, if all are equal
  contains
    procedure :: open => open_reader
    procedure :: next
    procedure :: close => close_reader
    procedure, private :: read_record
    procedure, private :: fetch
    procedure, private :: find_mark
  end type journal_reader

contains

  subroutine open_reader(self, path, error)
    !! Open a journal at its first record.
    !! **Errors**: the journal cannot be read.
    class(journal_reader), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: state
    integer :: problem
    self%path = path
    self%place = 0
    self%origin = 0
    self%have = 0
    self%damaged = 0
    problem = open_file(path, to_read_itself, self%descriptor)
    if (problem == 0) problem = look_at_open(self%descriptor, state)
    if (problem /= 0) call cannot_be_taken(error, path, problem)
    if (problem == 0 .and. state%kind /= is_file) call fail(error, status_bad_file, path//': is no file')
  end subroutine open_reader

  subroutine next(self, found, error)
    !! Go to the next sound record, past what is none. A last one that is not whole was under way when its process ended.
    !! **Errors**: the journal cannot be read.
    class(journal_reader), intent(inout) :: self
    logical, intent(out) :: found
    type(error_type), allocatable, intent(inout) :: error
    integer :: verdict
    logical :: is_bad, is_torn                              ! what was passed over
    found = .false.
    is_bad = .false.
    is_torn = .false.
    do while (.not. allocated(error))
      call self%read_record(verdict, error)
      found = verdict == is_sound
      if (found .or. verdict == is_none) exit
      is_bad = is_bad .or. verdict == is_damaged .or. is_torn    ! what was cut before was not the last
      is_torn = verdict == is_cut
      call self%find_mark(error)
    end do
    if (is_bad .or. (is_torn .and. found)) self%damaged = self%damaged + 1
  end subroutine next

  subroutine read_record(self, verdict, error)
    !! Find out what lies at the reader's place; a sound record is taken in, and the place is then behind it.
    class(journal_reader), intent(inout) :: self
    integer, intent(out) :: verdict
    type(error_type), allocatable, intent(inout) :: error
    integer(i8), pointer, contiguous :: words(:)
    real(dp), pointer, contiguous :: numbers(:)             ! and the word before them: there may be none
    integer(i8) :: head(header), count, length
    verdict = is_none
    call self%fetch(int(header, i8), words, error)
    if (.not. associated(words)) return
    head = words(:header)
    verdict = is_damaged
    if (head(1) /= mark .or. head(header) /= word_sum(head(:header - 1))) return
    verdict = is_cut
    count = head(at_count)
    length = header + count + words_of(head(at_letters))
    call self%fetch(length, words, error)
    if (.not. associated(words)) return
    verdict = is_damaged
    if (any(head(at_sums:at_sums + lanes - 1) /= lane_sums(words(header + 1:length)))) return
    verdict = is_sound
    self%case = head(at_case)
    self%work = head(at_work)
    call c_f_pointer(c_loc(words(header)), numbers, [count + 1])
    self%numbers => numbers(2:)
    call split(words(header + count + 1:length), head(at_letters), self%notes)
    self%place = self%place + word*length
    self%at_once = length*max(1_i8, read_at_once/length)
  end subroutine read_record

  subroutine fetch(self, count, words, error)
    !! Point to so many words from the reader's place on; to none where the file ends before.
    class(journal_reader), intent(inout) :: self
    integer(i8), intent(in) :: count
    integer(i8), pointer, contiguous, intent(out) :: words(:)
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: first
    integer :: problem
    words => null()
    first = (self%place - self%origin)/word + 1
    if (first + count - 1 > self%have) then
      self%origin = self%place
      first = 1
      call make_room(self%buffer, max(count, self%at_once), 0_i8)
      problem = read_words(self%descriptor, self%origin, self%buffer(:max(count, self%at_once)), self%have)
      if (problem /= 0) call cannot_be_taken(error, self%path, problem)
      if (problem /= 0 .or. count > self%have) return
    end if
    words => self%buffer(first:first + count - 1)
  end subroutine fetch

  subroutine find_mark(self, error)
    !! Go on to the next place, at any byte, where a record may begin, or to the end.
    class(journal_reader), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    integer(i1) :: bytes(65536)
    character(size(bytes)) :: text
    integer(i8) :: have
    integer :: problem, at
    self%place = self%place + 1
    do
      problem = read_bytes(self%descriptor, self%place, bytes, have)
      if (problem /= 0) call cannot_be_taken(error, self%path, problem)
      text(:have) = transfer(bytes(:have), text(:have))
      at = index(text(:have), transfer(mark, text(:word)))
      if (at > 0) self%place = self%place + at - 1
      if (at > 0 .or. have < word) exit
      self%place = self%place + have - word + 1
    end do
    self%origin = self%place
    self%have = 0
  end subroutine find_mark

  subroutine cannot_be_taken(error, path, problem)
    !! Fill `error` unless there is one already: what cannot be read now may be read another time.
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in) :: path
    integer, intent(in) :: problem
    if (.not. allocated(error)) call fail(error, status_bad_file, path//': cannot be read; it may hold finished cases ('// &
                                          reason(problem)//')')
  end subroutine cannot_be_taken

  pure subroutine split(words, letters, lines)
    !! The notes of a record, each of which has a line's end, one by one.
    integer(i8), intent(in) :: words(:), letters
    type(string), allocatable, intent(out) :: lines(:)
    character(letters) :: text
    text = transfer(words, text)
    lines = lines_of(text)
  end subroutine split

  subroutine close_reader(self)
    !! Close the journal; the numbers of its last record are gone.
    class(journal_reader), intent(inout) :: self
    integer :: ignored
    ignored = close_file(self%descriptor)
    if (associated(self%buffer)) deallocate (self%buffer)
    self%numbers => null()
  end subroutine close_reader

end module bw_journal_reader
