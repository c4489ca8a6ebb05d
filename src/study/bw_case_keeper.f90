module bw_case_keeper
  !! A process's finished cases on their way to the disk: what is long straight into the result, then the record of the case
  !! into the process's journal. A case counts from its record on.
  use bw_case_fields, only: put_fields
  use bw_case_journal, only: journal_writer
  use bw_case_result, only: case_result
  use bw_error, only: error_type, fail, fail_to_write, status_bad_file
  use bw_kinds, only: dp, i8
  use bw_posix, only: file_exists
  use bw_result_body, only: result_body
  use bw_stopwatch, only: wall_seconds
  implicit none (type, external)
  private

  real(dp), parameter :: look_every = 0.5_dp     !! s between two looks whether the files are still there

  type, public :: case_keeper
    character(:), allocatable, private :: path   !! of the journal
    character(:), allocatable, private :: work   !! whose cases these are
    type(result_body), private :: body
    type(journal_writer), private :: journal
    integer, private :: fields = 0               !! how many go into the journal: all, or those that are not long
    logical, private :: straight = .false.       !! the others do not
    logical, private :: is_open = .false.
    real(dp), private :: looked = 0.0_dp
    real(dp), allocatable :: numbers(:)          !! of the case at hand, as its record has them
  contains
    procedure :: begin
    procedure :: keep
    procedure :: end => end_journal
    procedure, private :: look
  end type case_keeper

contains

  subroutine begin(self, path, work, body, straight)
    class(case_keeper), intent(inout) :: self
    character(*), intent(in) :: path             !! of this process's journal, which begins with its first case
    character(*), intent(in) :: work             !! whose cases these are
    type(result_body), intent(in) :: body
    logical, intent(in) :: straight              !! this process may write there
    self%path = path
    self%work = work
    self%body = body
    self%straight = straight .and. body%known()
    self%fields = merge(body%short, size(body%fields), self%straight)
    allocate (self%numbers(merge(body%short_length(), body%case_length(), self%straight)))
  end subroutine begin

  subroutine keep(self, index, result, error)
    !! A finished case. **Errors**: a file cannot be written, or is gone.
    class(case_keeper), intent(inout) :: self
    integer(i8), intent(in) :: index
    type(case_result), intent(in) :: result
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: total
    logical :: kept
    total = 0
    kept = .true.
    if (self%straight) call self%body%put_long(index, result, total, error)
    if (allocated(error)) return
    if (.not. self%is_open) kept = self%journal%open(self%path, self%work)
    self%is_open = .true.
    call put_fields(result, self%body%fields(:self%fields), self%numbers)
    if (kept) kept = self%journal%put(index, self%numbers, result%notes, &
                                      self%body%case_length() - size(self%numbers, kind=i8), total)
    if (.not. kept) call fail_to_write(error, self%path)
    if (kept) call self%look(error)
  end subroutine keep

  subroutine look(self, error)
    !! Now and then, whether the files are still there.
    class(case_keeper), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: now
    now = wall_seconds()
    if (now - self%looked <= look_every) return
    self%looked = now
    if (self%straight) call look_for(self%body%path, error)
    call look_for(self%path, error)
  end subroutine look

  subroutine look_for(path, error)
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    if (file_exists(path)) return
    if (allocated(error)) deallocate (error)
    call fail(error, status_bad_file, path// &
              ': is gone: somebody has removed it while cases were done, or its file system is no longer there')
  end subroutine look_for

  subroutine end_journal(self)
    class(case_keeper), intent(inout) :: self
    call self%journal%close()
  end subroutine end_journal

end module bw_case_keeper
