module scene_texts
  !! Scenes as texts, and what the reader makes of them; shared by the tests of this folder.
  use bw_error, only: error_type
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use bw_scene_resolved, only: resolved_text
  use written_scenes, only: scene_of
  implicit none (type, external)
  private
  public :: accepted, lines_of, refusal, resolved, says, scene_of

  character, parameter, public :: nl = new_line('a')
  character(*), parameter, public :: beam = '&beam length=1 density=7870 youngs_modulus=2e11 diameter=0.037 /'//nl
  character(*), parameter, public :: impact = '&impact mass_ratio=0.2 /'//nl
  character(*), parameter, public :: response = '&response duration=0.2 samples=64 /'//nl
  character(*), parameter, public :: whole = &
    "&scene title='all groups' /"//nl//beam//'&rotation angular_velocity=50 /'//nl//impact//'&capture /'//nl// &
    '&modes before=40 /'//nl//response//'&spectrum /'//nl
    !! every group but &sweep, one per line

contains

  function refusal(text) result(message)
    !! All that is wrong with a text; empty if it is accepted.
    character(*), intent(in) :: text
    character(:), allocatable :: message
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    call read_scene_text(text, 'x.nml', scene, error)
    message = ''
    if (allocated(error)) message = error%message
  end function refusal

  logical function accepted(text)
    character(*), intent(in) :: text
    accepted = refusal(text) == ''
  end function accepted

  logical function says(text, piece)
    !! Is the text refused with a message that goes on like this behind the file's name?
    character(*), intent(in) :: text, piece
    says = index(nl//refusal(text), nl//'x.nml'//piece) > 0
  end function says

  function resolved(text) result(again)
    !! The resolved scene of a text; empty if it is refused.
    character(*), intent(in) :: text
    character(:), allocatable :: again
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    call read_scene_text(text, 'x.nml', scene, error)
    again = ''
    if (.not. allocated(error)) again = resolved_text(scene)
  end function resolved

  pure integer function lines_of(text)
    !! Lines of a text whose last line has no end.
    character(*), intent(in) :: text
    integer :: i
    lines_of = 1 + count([(text(i:i) == nl, i=1, len(text))])
  end function lines_of

end module scene_texts
