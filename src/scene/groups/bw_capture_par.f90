module bw_capture_par
  !! `&capture`: the mass stays at the tip after the impact.
  use bw_input_name, only: input_group, input_name
  use bw_input_values, only: group_values, position_of
  implicit none (type, external)
  private
  public :: build_capture

  type, public :: capture_par
    !! Nothing to say yet beyond being there.
  end type capture_par

  type(input_group), parameter, public :: capture_group = input_group( &
    'capture', needs='impact', absent='the mass rebounds')

  type(input_name), parameter, public :: capture_names(0) = [input_name ::]

contains

  pure subroutine build_capture(groups, capture)
    type(group_values), intent(in) :: groups(:)
    type(capture_par), allocatable, intent(out) :: capture   !! unallocated where the group is absent
    if (position_of(groups, 'capture') > 0) allocate (capture)
  end subroutine build_capture

end module bw_capture_par
