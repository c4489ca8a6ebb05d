module bw_result_supplement
  !! Additions to a result by other rooms: their variables are defined with all others, and their values are put when
  !! all cases are done, before the result has its name.
  use bw_classic_head, only: classic_head
  use bw_error, only: error_type
  use bw_monitor, only: monitor_type
  use bw_result_table, only: result_table
  implicit none (type, external)
  private

  type, abstract, public :: result_supplement
    logical :: trusted = .true.                                !! the findings of `add` can be trusted
    character(:), allocatable :: identity                      !! the data used beside the scene and its record
  contains
    procedure(attributes_interface), deferred :: attributes
    procedure(rows_interface), deferred :: rows
    procedure(add_interface), deferred :: add
  end type result_supplement

  abstract interface
    subroutine attributes_interface(self, head)
      !! Adds attributes to the file, and room for those known at the end.
      import :: classic_head, result_supplement
      class(result_supplement), intent(in) :: self
      class(classic_head), intent(inout) :: head
    end subroutine attributes_interface

    subroutine rows_interface(self, table)
      !! Walks through the rows of its variables; while they are defined, values are unknown.
      import :: result_supplement, result_table
      class(result_supplement), intent(in) :: self
      class(result_table), intent(inout) :: table
    end subroutine rows_interface

    subroutine add_interface(self, draft, monitor, notes, report, whole, error)
      !! Puts the values, and adds notes and a report. Called by the leader alone.
      !! **Errors**: needed data cannot be read.
      import :: error_type, monitor_type, result_supplement, result_table
      class(result_supplement), intent(inout) :: self
      class(result_table), intent(inout) :: draft              !! of the result, with all cases
      class(monitor_type), intent(inout), target :: monitor    !! may request a stop
      character(:), allocatable, intent(inout) :: notes        !! lines
      character(:), allocatable, intent(inout) :: report       !! printed, lines
      logical, intent(out) :: whole                            !! false if the monitor asked to stop
      type(error_type), allocatable, intent(inout) :: error
    end subroutine add_interface
  end interface

end module bw_result_supplement
