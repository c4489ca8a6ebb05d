module bw_case_block
  !! Some neighbouring cases on their way to the result file, where they lie field by field: all numbers of a field
  !! together, as they are written.
  use bw_case_fields, only: case_field, case_length
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: block_for

  integer(i8), parameter :: block_numbers = 1000000     !! 8 MB are written at a time; a single case may be more

  type, public :: case_block
    integer :: room = 0                                 !! cases
    integer :: held = 0                                 !! how many there are
    real(dp), allocatable :: numbers(:)                 !! (numbers of a case · room)
  contains
    procedure :: add
    procedure :: begin_of
  end type case_block

contains

  pure type(case_block) function block_for(fields, cases) result(block)
    !! An empty block.
    type(case_field), intent(in) :: fields(:)
    integer, intent(in) :: cases                        !! of the sweep
    block%room = int(max(1_i8, min(int(cases, i8), block_numbers/case_length(fields))))
    allocate (block%numbers(case_length(fields)*block%room))
  end function block_for

  pure subroutine add(self, fields, numbers)
    !! Take one more case; there is room for it.
    class(case_block), intent(inout) :: self
    type(case_field), intent(in) :: fields(:)
    real(dp), intent(in), contiguous :: numbers(:)      !! (case_length)
    integer(i8) :: first
    integer :: i
    do i = 1, size(fields)
      first = self%begin_of(fields(i)) + self%held*fields(i)%length
      self%numbers(first:first + fields(i)%length - 1) = numbers(fields(i)%first:fields(i)%first + fields(i)%length - 1)
    end do
    self%held = self%held + 1
  end subroutine add

  pure integer(i8) function begin_of(self, field)
    !! Where the numbers of a field begin.
    class(case_block), intent(in) :: self
    type(case_field), intent(in) :: field
    begin_of = (field%first - 1)*self%room + 1
  end function begin_of

end module bw_case_block
