module bw_scene_reader
  !! From a file, or its text, to a scene: all that is wrong with it is reported at once.
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_kinds, only: i8
  use bw_scene, only: scene_type
  use bw_scene_cases, only: check_corners, complete
  use bw_scene_checks, only: check_groups
  use bw_scene_fill, only: fill_groups
  use bw_scene_lexer, only: tokenise
  use bw_scene_messages, only: message_list
  use bw_scene_parser, only: parse, parsed_scene
  use bw_scene_sweeps, only: take_sweeps
  use bw_scene_tokens, only: token
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: read_scene, read_scene_text, stem

  integer, parameter :: most_reason = 200    !! characters of the system's own message
  integer, parameter :: most_bytes = 2**26   !! a scene of 64 MB holds more values than a sweep may have

contains

  subroutine read_scene(path, scene, error)
    !! Read, check and complete the scene in a file.
    character(*), intent(in) :: path
    type(scene_type), intent(out) :: scene
    type(error_type), allocatable, intent(out) :: error
      !! `status_bad_file` where the file cannot be read; `status_bad_input` where the scene is wrong, with one line
      !! `FILE:LINE: group%name: what is wrong, what would be accepted` for each error
    character(:), allocatable :: text
    call read_text(path, text, error)
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

  subroutine read_text(path, text, error)
    !! The bytes of a file.
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    character(most_reason) :: reason
    integer(i8) :: bytes
    integer :: unit, stat
    open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', &
          iostat=stat, iomsg=reason)
    if (stat == 0) then
      inquire (unit, size=bytes)
      call read_bytes(unit, bytes, text, stat, reason)
      close (unit)
    end if
    if (stat /= 0) call fail(error, status_bad_file, path//': cannot be read: '//trim(reason))
  end subroutine read_text

  subroutine read_bytes(unit, bytes, text, stat, reason)
    integer, intent(in) :: unit
    integer(i8), intent(in) :: bytes                !! size of a file; 0 or less for an empty one, and for a pipe
    character(:), allocatable, intent(out) :: text
    integer, intent(out) :: stat
    character(most_reason), intent(inout) :: reason
    stat = 0
    if (bytes > most_bytes) then
      stat = 1
      reason = 'larger than '//text_of(most_bytes)//' bytes, which no scene is'
    else if (bytes > 0) then
      allocate (character(bytes) :: text)
      read (unit, iostat=stat, iomsg=reason) text
      if (stat /= 0) return
    else
      call read_pipe(unit, text, stat, reason)
    end if
  end subroutine read_bytes

  subroutine read_pipe(unit, text, stat, reason)
    !! Read to the end, byte by byte, what does not tell its size.
    integer, intent(in) :: unit
    character(:), allocatable, intent(out) :: text
    integer, intent(out) :: stat
    character(most_reason), intent(inout) :: reason
    integer, parameter :: most_piped = 2**20
    character(:), allocatable :: buffer
    integer :: n
    allocate (character(most_piped) :: buffer)
    do n = 1, most_piped
      read (unit, iostat=stat, iomsg=reason) buffer(n:n)
      if (is_iostat_end(stat)) exit
      if (stat /= 0) return
    end do
    text = buffer(:min(n - 1, most_piped))
    stat = 0
    if (n <= most_piped) return
    stat = 1
    reason = 'more than '//text_of(most_piped)//' bytes from a pipe'
  end subroutine read_pipe

end module bw_scene_reader
