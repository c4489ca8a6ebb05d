module bw_progress
  !! A monitor that also follows a scene from case to case.
  use bw_kinds, only: i8
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private

  type, abstract, extends(monitor_type), public :: progress_type
  contains
    procedure(begin_interface), deferred :: begin
    procedure(cases_interface), deferred :: cases_done
    procedure(end_interface), deferred :: end
  end type progress_type

  abstract interface
    subroutine begin_interface(self, name, cases, finished)
      import :: progress_type, i8
      implicit none (type, external)
      class(progress_type), intent(inout) :: self
      character(*), intent(in) :: name          !! of the scene
      integer(i8), intent(in) :: cases          !! how many it has
      integer(i8), intent(in) :: finished       !! how many an earlier run had finished
    end subroutine begin_interface

    subroutine cases_interface(self, count)
      import :: progress_type, i8
      implicit none (type, external)
      class(progress_type), intent(inout) :: self
      integer(i8), intent(in) :: count          !! cases that have been finished since the last call
    end subroutine cases_interface

    subroutine end_interface(self)
      import :: progress_type
      implicit none (type, external)
      class(progress_type), intent(inout) :: self
    end subroutine end_interface
  end interface

end module bw_progress
