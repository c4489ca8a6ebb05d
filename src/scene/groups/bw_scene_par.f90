module bw_scene_par
  !! `&scene`: the title of a run.
  use bw_input_name, only: input_group, input_name, text_input
  use bw_input_values, only: group_values
  implicit none (type, external)
  private
  public :: build_header

  type, public :: scene_par
    character(:), allocatable :: title
  end type scene_par

  type(input_group), parameter, public :: scene_group = input_group( &
    'scene', implied=.true., absent='the run has no title', &
    physics='Names the run. It changes no number.', &
    example='&scene title = ''A rotating arm catches a payload'' /')

  type(input_name), parameter, public :: scene_names(*) = [ &
    input_name('scene', 'title', text_input, default="''", meaning='title of the run, in its report and result')]

contains

  pure type(scene_par) function build_header(values) result(header)
    !! Build the header from checked values.
    type(group_values), intent(in) :: values
    header%title = values%text('title')
  end function build_header

end module bw_scene_par
