module bw_scene_par
  !! `&scene`: what a run is called.
  use bw_input_name, only: input_group, input_name, text_input
  use bw_input_values, only: group_values, position_of
  implicit none (type, external)
  private
  public :: build_header

  type, public :: scene_par
    character(:), allocatable :: title
  end type scene_par

  type(input_group), parameter, public :: scene_group = input_group( &
    'scene', implied=.true., absent='the run has no title')

  type(input_name), parameter, public :: scene_names(*) = [ &
    input_name('scene', 'title', text_input, default="''", meaning='title of the run, in its report and result')]

contains

  pure subroutine build_header(groups, header)
    !! From checked values.
    type(group_values), intent(in) :: groups(:)
    type(scene_par), intent(out) :: header
    header%title = groups(position_of(groups, 'scene'))%text('title')
  end subroutine build_header

end module bw_scene_par
