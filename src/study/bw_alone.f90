module bw_alone
  !! A crew of one process, which hands out to itself.
  use bw_case_queue, only: case_queue
  use bw_crew, only: crew_type
  use bw_error, only: error_type
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private

  type, extends(crew_type), public :: alone
    private
    type(case_queue) :: queue
    logical :: has_stopped = .false.
  contains
    procedure :: join => do_nothing
    procedure :: part => do_nothing
    procedure :: case_done => do_nothing
    procedure :: agree
    procedure :: begin
    procedure :: next
    procedure :: attend
    procedure :: stop => stop_alone
    procedure :: stopped
    procedure :: end => end_alone
  end type alone

contains

  subroutine do_nothing(self)
    class(alone), intent(inout) :: self
    associate (unused => self)
    end associate
  end subroutine do_nothing

  subroutine agree(self, value)
    class(alone), intent(inout) :: self
    integer, intent(inout) :: value
    associate (unused => self, agreed => value)
    end associate
  end subroutine agree

  subroutine begin(self, queue)
    class(alone), intent(inout) :: self
    type(case_queue), intent(in) :: queue
    self%queue = queue
    self%has_stopped = .false.
  end subroutine begin

  subroutine next(self, first, last)
    class(alone), intent(inout) :: self
    integer(i8), intent(out) :: first, last
    call self%queue%take(self%queue%left, first, last)
  end subroutine next

  subroutine attend(self, done)
    class(alone), intent(inout) :: self
    integer(i8), intent(out) :: done
    associate (unused => self)
    end associate
    done = 0
  end subroutine attend

  subroutine stop_alone(self)
    class(alone), intent(inout) :: self
    call self%queue%drop_all()
    self%has_stopped = .true.
  end subroutine stop_alone

  logical function stopped(self)
    class(alone), intent(in) :: self
    stopped = self%has_stopped
  end function stopped

  subroutine end_alone(self, totals, error)
    class(alone), intent(inout) :: self
    real(dp), intent(inout) :: totals(:)
    type(error_type), allocatable, intent(inout) :: error
    associate (unused => self, mine => totals, too => error)
    end associate
  end subroutine end_alone

end module bw_alone
