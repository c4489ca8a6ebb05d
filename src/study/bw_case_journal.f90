module bw_case_journal
  !! Finished cases of a sweep, kept until all are done: one record a case, written at once and whole, so that it outlives
  !! the process, however that ends. A journal is written by one process and never changed afterwards; only its last
  !! record can be torn. The first record holds no case but the text of the work that the journal belongs to. Numbers of a
  !! case that lie elsewhere already are not in its record, but their checksum is.
  use bw_descriptor, only: close_descriptor, new_file, open_to_read
  use bw_kinds, only: dp, i8
  use bw_text, only: append, string
  use bw_word_file, only: as_words, checksum, read_words, words_in_file, write_words
  implicit none (type, external)
  private

  integer(i8), parameter :: mark = 7311138210646680930_i8   !! 'beamwave' as a word: how every record begins
  integer, parameter :: header_length = 7
    !! mark, case, numbers, length of the notes, numbers that lie elsewhere, their checksum, checksum of the record
  integer, parameter :: word = 8                            !! bytes

  type, public :: journal_writer
    private
    integer :: descriptor = -1
    integer(i8), allocatable :: record(:)                   !! kept from case to case
  contains
    procedure :: open => open_writer
    procedure :: put
    procedure :: close => close_writer
  end type journal_writer

  type, public :: journal_reader
    private
    integer :: descriptor = -1
    integer(i8) :: position = 1                             !! of the next record, in words
    integer(i8) :: size = 0                                 !! of the file when it was looked at last, words
    integer(i8) :: header(header_length) = 0                !! of the record at hand
    integer(i8), allocatable :: body(:)                     !! of that record, kept from case to case
  contains
    procedure :: open => open_reader
    procedure :: next
    procedure :: elsewhere
    procedure :: total_elsewhere
    procedure :: take
    procedure :: close => close_reader
  end type journal_reader

contains

  logical function open_writer(self, path, work) result(done)
    !! Begin a journal. What is there under this name is lost.
    class(journal_writer), intent(inout) :: self
    character(*), intent(in) :: path
    character(*), intent(in) :: work                        !! whose cases these are
    type(string) :: text(1)
    self%descriptor = new_file(path)
    done = self%descriptor >= 0
    text(1)%text = work
    if (done) done = self%put(0_i8, [real(dp) ::], text, 0_i8, 0_i8)
  end function open_writer

  logical function put(self, index, numbers, notes, elsewhere, total) result(done)
    !! Keep a case. False where the system refuses it: a full disk.
    class(journal_writer), intent(inout) :: self
    integer(i8), intent(in) :: index                        !! of the case
    real(dp), intent(in), contiguous, target :: numbers(:)  !! all, or those that do not lie elsewhere
    type(string), intent(in) :: notes(:)
    integer(i8), intent(in) :: elsewhere                    !! how many do
    integer(i8), intent(in) :: total                        !! their checksum
    character(:), allocatable :: text
    integer(i8) :: n, words
    text = text_of_lines(notes)
    n = size(numbers, kind=i8)
    words = n + words_of(len(text, i8))
    call make_room(self%record, header_length + words)
    associate (body => self%record(header_length + 1:header_length + words), bits => as_words(numbers))
      body(:n) = bits
      if (words > n) body(n + 1:) = transfer(text//repeat(' ', word), body, words - n)
      self%record(:header_length) = [mark, index, n, len(text, i8), elsewhere, total, 0_i8]
      self%record(header_length) = sum_of(self%record(:header_length), body)
    end associate
    done = write_words(self%descriptor, self%record(:header_length + words))
  end function put

  pure integer(i8) function sum_of(header, body) result(total)
    !! The checksum of a record.
    integer(i8), intent(in) :: header(header_length)
    integer(i8), intent(in), contiguous :: body(:)
    total = ieor(ishftc(checksum(header(:header_length - 1)), 1), checksum(body))
  end function sum_of

  pure subroutine make_room(words, least)
    !! Room for so many words at least, whose values mean nothing.
    integer(i8), allocatable, intent(inout) :: words(:)
    integer(i8), intent(in) :: least
    if (allocated(words)) then
      if (size(words, kind=i8) >= least) return
      deallocate (words)
    end if
    allocate (words(least))
  end subroutine make_room

  pure integer(i8) function words_of(letters)
    !! How many words hold so many letters.
    integer(i8), intent(in) :: letters
    words_of = (letters + word - 1)/word
  end function words_of

  subroutine close_writer(self)
    class(journal_writer), intent(inout) :: self
    call close_descriptor(self%descriptor)
    self%descriptor = -1
  end subroutine close_writer

  logical function open_reader(self, path, work, readable) result(same)
    !! Open a journal; false where it cannot be read or belongs to other work.
    class(journal_reader), intent(inout) :: self
    character(*), intent(in) :: path
    character(*), intent(in) :: work
    logical, intent(out), optional :: readable
    type(string), allocatable :: notes(:)
    real(dp) :: nothing(0)
    integer(i8) :: index
    same = .false.
    self%descriptor = open_to_read(path)
    if (present(readable)) readable = self%descriptor >= 0
    if (self%descriptor < 0) return
    self%position = 1
    self%size = 0
    if (self%next(index)) same = index == 0 .and. self%header(3) == 0
    if (same) same = self%take(nothing, notes)
    if (same) same = text_of_lines(notes) == work//new_line('a')
    if (.not. same) call self%close()
  end function open_reader

  logical function next(self, index) result(found)
    !! Go to the next record that is whole by now.
    class(journal_reader), intent(inout) :: self
    integer(i8), intent(out) :: index                       !! of its case
    integer(i8) :: header(header_length), length
    index = 0
    found = .false.
    if (self%position + header_length > self%size + 1) self%size = words_in_file(self%descriptor)
    if (self%position + header_length > self%size + 1) return
    if (.not. read_words(self%descriptor, self%position, header)) return
    if (header(1) /= mark .or. any(header(2:5) < 0)) return
    if (any(header(3:4) > word*self%size)) return           ! so that the next line cannot overflow
    length = header_length + header(3) + words_of(header(4))
    if (self%position + length > self%size + 1) self%size = words_in_file(self%descriptor)
    found = self%position + length <= self%size + 1
    if (.not. found) return
    self%position = self%position + length
    self%header = header
    index = header(2)
  end function next

  pure integer(i8) function elsewhere(self)
    !! How many numbers of the case of the record at hand lie elsewhere.
    class(journal_reader), intent(in) :: self
    elsewhere = self%header(5)
  end function elsewhere

  pure integer(i8) function total_elsewhere(self) result(total)
    !! Their checksum.
    class(journal_reader), intent(in) :: self
    total = self%header(6)
  end function total_elsewhere

  logical function take(self, numbers, notes) result(sound)
    !! The case of the record at hand. False where it does not have that many numbers, or is not as it was written.
    class(journal_reader), intent(inout) :: self
    real(dp), intent(out) :: numbers(:)
    type(string), allocatable, intent(out) :: notes(:)
    integer(i8) :: n, words
    allocate (notes(0))
    n = self%header(3)
    sound = size(numbers, kind=i8) == n
    if (.not. sound) return
    words = n + words_of(self%header(4))
    call make_room(self%body, words)
    sound = read_words(self%descriptor, self%position - words, self%body(:words))
    if (sound) sound = self%header(header_length) == sum_of(self%header, self%body(:words))
    if (.not. sound) return
    numbers = transfer(self%body(:n), numbers, n)
    if (words > n) call split(text_of_words(self%body(n + 1:words), self%header(4)), notes)
  end function take

  pure function text_of_words(words, length) result(text)
    integer(i8), intent(in) :: words(:), length
    character(length) :: text
    character(word*size(words)) :: whole
    whole = transfer(words, whole)
    text = whole(:length)
  end function text_of_words

  pure subroutine split(text, lines)
    !! Lines, each with its end.
    character(*), intent(in) :: text
    type(string), allocatable, intent(inout) :: lines(:)
    integer :: first, last
    first = 1
    do while (first <= len(text))
      last = first + index(text(first:)//new_line('a'), new_line('a')) - 2
      call append(lines, text(first:last))
      first = last + 2
    end do
  end subroutine split

  pure function text_of_lines(lines) result(text)
    type(string), intent(in) :: lines(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(lines)
      text = text//lines(i)%text//new_line('a')
    end do
  end function text_of_lines

  subroutine close_reader(self)
    class(journal_reader), intent(inout) :: self
    call close_descriptor(self%descriptor)
    self%descriptor = -1
  end subroutine close_reader

end module bw_case_journal
