module bw_result_supplement
  !! What else is put into a result when it is whole but has not its name yet, by whoever knows what: so a result that has its
  !! name has all.
  use bw_error, only: error_type
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private

  type, abstract, public :: result_supplement
    logical :: trusted = .true.                  !! what `add` found can be
  contains
    procedure(add_interface), deferred :: add
  end type result_supplement

  abstract interface
    subroutine add_interface(self, draft, monitor, notes, report, whole, error)
      !! Puts more into the result, and adds what there is to say of it. Called by the leader alone.
      !! **Errors**: the draft cannot be read or written; it is of no use then.
      import :: error_type, monitor_type, result_supplement
      implicit none (type, external)
      class(result_supplement), intent(inout) :: self
      character(*), intent(in) :: draft                        !! path of the result for the time being
      class(monitor_type), intent(inout) :: monitor            !! may ask to stop
      character(:), allocatable, intent(inout) :: notes        !! lines
      character(:), allocatable, intent(inout) :: report       !! what is printed of the numbers, lines
      logical, intent(out) :: whole                            !! false where the monitor asked to stop
      type(error_type), allocatable, intent(inout) :: error
    end subroutine add_interface
  end interface

end module bw_result_supplement
