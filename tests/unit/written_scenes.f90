module written_scenes
  !! Scenes that tests write as texts.
  use bw_error, only: error_type
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  implicit none (type, external)
  private
  public :: scene_of

contains

  function scene_of(text) result(scene)
    !! That of a text that is known to be accepted; what is wrong with another is printed.
    character(*), intent(in) :: text
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    call read_scene_text(text, 'x.nml', scene, error)
    if (allocated(error)) print '(a)', error%message
  end function scene_of

end module written_scenes
