module bw_scene_reader
  !! Reads a scene from a file or a text, and reports all its errors at once. In place of a file there may be a pipe, as a
  !! shell makes it of `<(command)`.
  !!
  !! The steps are text ► tokens (bw_scene_lexer) ► groups and statements (bw_scene_parser) ► values (bw_scene_fill, each
  !! statement by bw_scene_items, bw_scene_entries and bw_scene_scalars) ► the scene.
  use, intrinsic :: iso_c_binding, only: c_loc
  use bw_descriptors, only: close_file, look_at_open, open_file, read_bytes, to_read
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_files, only: cannot_be_read, look_at, path_state
  use bw_kinds, only: i1, i8
  use bw_scene, only: scene_type
  use bw_scene_cases, only: check_corners, complete
  use bw_scene_checks, only: check_groups
  use bw_scene_design, only: extract_design
  use bw_scene_fill, only: fill_groups
  use bw_scene_lexer, only: tokenise
  use bw_scene_messages, only: message_list
  use bw_scene_parser, only: parse, parsed_scene
  use bw_scene_sweeps, only: add_repeats, extract_sweeps
  use bw_scene_tokens, only: token
  use bw_scene_unknowns, only: check_ranges, extract_unknowns
  use bw_system_calls, only: bw_listen, is_directory, is_file
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: read_scene, read_scene_text, stem

  integer(i8), parameter :: most_bytes = 2_i8**26   !! 64 MB, more than any scene needs
  integer(i8), parameter :: most_piped = 2_i8**20
  integer, parameter :: patience = 5000             !! ms without data from a pipe

contains

  subroutine read_scene(path, scene, error)
    !! Read, check and complete the scene in a file.
    character(*), intent(in) :: path
    type(scene_type), intent(out) :: scene
    type(error_type), allocatable, intent(out) :: error
      !! `status_bad_file` if the file, or the table of its `&design`, cannot be read; `status_bad_input` if the scene is
      !! wrong, with one line `FILE:LINE: group%name: what is wrong, what would be accepted` for each error
    character(:), allocatable :: text
    call read_scene_bytes(path, text, error)
    if (.not. allocated(error)) call read_scene_text(text, path, scene, error)
  end subroutine read_scene

  subroutine read_scene_text(text, path, scene, error)
    !! Read, check and complete the scene in a text; `path` names it in messages and locates the table of a `&design`.
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
      call extract_sweeps(scene%groups, scene%sweeps, messages)
      call extract_design(path, scene%groups, scene%sweeps, scene%design, messages, error)
      call add_repeats(scene%groups, scene%sweeps)
      call extract_unknowns(scene%groups, scene%sweeps, scene%unknowns, messages)
      if (.not. allocated(scene%design) .or. any(scene%sweeps%designed)) then     ! else the values of the table are not known
        call check_groups(scene%groups, messages)
        call complete(scene, messages)
        if (messages%count == 0) call check_corners(scene, messages)
        if (messages%count == 0) call check_ranges(scene, messages)
      end if
    end if
    if (messages%count == 0) return
    if (allocated(error)) error%message = error%message//new_line('a')//messages%text()
    if (.not. allocated(error)) call fail(error, status_bad_input, messages%text())
  end subroutine read_scene_text

  pure function stem(path) result(name)
    !! Return the stem of a path: `runs/fig2.nml` → `fig2`.
    character(*), intent(in) :: path
    character(:), allocatable :: name
    integer :: point
    name = path(index(path, '/', back=.true.) + 1:)
    point = index(name, '.', back=.true.)
    if (point > 1) name = name(:point - 1)
  end function stem

  subroutine read_scene_bytes(path, text, error)
    !! Read the text of a file or a pipe.
    !! **Errors**: `status_bad_file` if it does not exist, cannot be read, or is larger than any scene.
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    type(path_state) :: state
    integer :: descriptor, ignored, problem
    problem = open_file(path, to_read, descriptor)
    if (problem == 0) problem = look_at_open(descriptor, state)
    if (problem /= 0) then
      call cannot_be_read(error, path, problem)
      if (look_at(path//'.nml', state) == 0 .and. state%kind == is_file) error%message = error%message//'; '//path// &
        '.nml is there'
    else if (state%kind == is_directory) then
      call fail(error, status_bad_file, path//': is a directory')
    else if (state%kind == is_file) then
      call read_file(path, descriptor, state%bytes, text, error)
    else
      call read_pipe(path, descriptor, text, error)
    end if
    ignored = close_file(descriptor)
  end subroutine read_scene_bytes

  subroutine read_file(path, descriptor, bytes, text, error)
    !! Read a whole file; reject one that is larger than any scene.
    character(*), intent(in) :: path
    integer, intent(in) :: descriptor
    integer(i8), intent(in) :: bytes                !! size of the file
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(inout) :: error
    integer(i1), allocatable :: buffer(:)
    integer(i8) :: have
    integer :: problem
    if (bytes > most_bytes) then
      call fail(error, status_bad_file, path//': larger than '//text_of(most_bytes)//' bytes, too large for a scene')
      return
    end if
    allocate (buffer(bytes))
    problem = read_bytes(descriptor, 0_i8, buffer, have)
    if (problem /= 0) call cannot_be_read(error, path, problem)
    text = text_from(buffer(:have))
  end subroutine read_file

  subroutine read_pipe(path, descriptor, text, error)
    !! Read a pipe to its end. The wait for data is limited, since nobody may write.
    character(*), intent(in) :: path
    integer, intent(in) :: descriptor
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(inout) :: error
    integer(i1), allocatable, target :: buffer(:)
    integer(i8) :: have, more
    allocate (buffer(most_piped + 1))
    have = 0
    do
      more = bw_listen(descriptor, c_loc(buffer(have + 1)), size(buffer, kind=i8) - have, patience)
      if (more < 0) call fail(error, status_bad_file, path//': is not a file, and yields no data')
      if (more <= 0) exit
      have = have + more
      if (have <= most_piped) cycle
      call fail(error, status_bad_file, path//': is not a file, and yields more than '//text_of(most_piped)//' bytes')
      exit
    end do
    text = text_from(buffer(:have))
  end subroutine read_pipe

  pure function text_from(bytes) result(text)
    !! Convert bytes to the same characters.
    integer(i1), intent(in) :: bytes(:)
    character(:), allocatable :: text
    integer :: i
    allocate (character(size(bytes)) :: text)
    do i = 1, size(bytes)
      text(i:i) = transfer(bytes(i), 'a')
    end do
  end function text_from

end module bw_scene_reader
