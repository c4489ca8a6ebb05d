module bw_scene_reader
  !! From a file, or its text, to a scene: all that is wrong with it is reported at once.
  use bw_error, only: error_type, fail, status_bad_input
  use bw_scene, only: scene_type
  use bw_scene_bytes, only: read_scene_bytes
  use bw_scene_cases, only: check_corners, complete
  use bw_scene_checks, only: check_groups
  use bw_scene_fill, only: fill_groups
  use bw_scene_lexer, only: tokenise
  use bw_scene_messages, only: message_list
  use bw_scene_parser, only: parse, parsed_scene
  use bw_scene_sweeps, only: take_sweeps
  use bw_scene_tokens, only: token
  implicit none (type, external)
  private
  public :: read_scene, read_scene_text, stem

contains

  subroutine read_scene(path, scene, error)
    !! Read, check and complete the scene in a file.
    character(*), intent(in) :: path
    type(scene_type), intent(out) :: scene
    type(error_type), allocatable, intent(out) :: error
      !! `status_bad_file` where the file cannot be read; `status_bad_input` where the scene is wrong, with one line
      !! `FILE:LINE: group%name: what is wrong, what would be accepted` for each error
    character(:), allocatable :: text
    call read_scene_bytes(path, text, error)
    if (.not. allocated(error)) call read_scene_text(text, path, scene, error)
  end subroutine read_scene

  pure subroutine read_scene_text(text, path, scene, error)
    !! The same for a text; `path` names it in messages.
    character(*), intent(in) :: text
    character(*), intent(in) :: path
    type(scene_type), intent(out) :: scene
    type(error_type), allocatable, intent(out) :: error
    type(token), allocatable :: tokens(:)
    type(parsed_scene) :: parsed
    type(message_list) :: messages
    messages%file = path
    scene%file = path
    scene%name = stem(path)
    call tokenise(text, .false., tokens, messages)
    call parse(text, tokens, parsed, messages)
    if (.not. messages%cut) then
      call fill_groups(text, tokens, parsed, scene%groups, messages)
      call take_sweeps(scene%groups, scene%sweeps, messages)
      call check_groups(scene%groups, messages)
      call complete(scene, messages)
    end if
    if (messages%count == 0) call check_corners(scene, messages)
    if (messages%count > 0) call fail(error, status_bad_input, messages%text())
  end subroutine read_scene_text

  pure function stem(path) result(name)
    !! `runs/fig2.nml` → `fig2`.
    character(*), intent(in) :: path
    character(:), allocatable :: name
    integer :: point
    name = path(index(path, '/', back=.true.) + 1:)
    point = index(name, '.', back=.true.)
    if (point > 1) name = name(:point - 1)
  end function stem

end module bw_scene_reader
