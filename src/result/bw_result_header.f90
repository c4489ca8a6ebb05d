module bw_result_header
  !! The attributes of a file: scene, program and history; and room for texts known at the end.
  use bw_classic_head, only: classic_head
  use bw_file_lock, only: own_host
  use bw_kinds, only: i4
  use bw_scene, only: effect_names, method_name, scene_type
  use bw_scene_resolved, only: given_names, resolved_text
  use bw_text, only: replaced
  use bw_version, only: program_commit, program_compiler, program_libraries, program_native, program_version
  implicit none (type, external)
  private
  public :: history_text, put_attributes, source_text, time_stamp

  integer(i4), parameter :: format_version = 2
  integer, parameter :: history_room = 1000, notes_room = 8000, report_room = 16000      !! letters; longer texts are cut

contains

  pure function source_text() result(text)
    !! Return the program, its version and its commit.
    character(:), allocatable :: text
    text = 'beamwave '//program_version//' ('//program_commit//')'
  end function source_text

  subroutine put_attributes(head, scene, study)
    !! Put the attributes of the file, with room for later ones.
    type(classic_head), intent(inout) :: head
    type(scene_type), intent(in) :: scene
    character(*), intent(in), optional :: study   !! the study that makes the result; absent: a run
    call put('Conventions', 'CF-1.11')
    call head%add_wholes('format_version', [format_version], of_file=.true.)
    call put('title', trim(scene%header%title))
    call put('source', source_text())
    call head%add_room('created', len(time_stamp()))
    call head%add_room('history', history_room)
    if (present(study)) call put('study', study)
    call put('scene', trim(resolved_text(scene)))
    if (allocated(scene%design)) call put('design_checksum', scene%design%checksum)
    call put('given', given_names(scene))
    call put('effects', effect_names(scene))
    call put('method', trim(method_name(scene)))
    call head%add_room('notes', notes_room)
    call head%add_room('report', report_room*merge(4, 1, allocated(scene%record)))
    call put('compiler', program_compiler//trim(merge(', tuned for its processor', repeat(' ', 25), program_native)))
    call put('libraries', program_libraries)
  contains
    subroutine put(name, text)
      character(*), intent(in) :: name, text
      call head%add_text(name, text, of_file=.true.)
    end subroutine put
  end subroutine put_attributes

  function history_text(scene, study) result(text)
    !! Return when, on which host and by which command a file was begun.
    type(scene_type), intent(in) :: scene
    character(*), intent(in), optional :: study   !! as above
    character(:), allocatable :: text
    text = time_stamp()//' '//own_host()//': '//called_as(scene, study)
  end function history_text

  function called_as(scene, study) result(text)
    !! Return the command as called, with its options; the scene's file is added if a directory stands for it.
    type(scene_type), intent(in) :: scene
    character(*), intent(in), optional :: study   !! as above
    character(:), allocatable :: text, word
    logical :: named
    integer :: i, length
    text = 'beamwave'
    named = .false.
    do i = 1, command_argument_count()
      call get_command_argument(i, length=length)
      if (allocated(word)) deallocate (word)
      allocate (character(length) :: word)
      if (length > 0) call get_command_argument(i, word)
      named = named .or. word == scene%file
      text = text//' '//quoted(word)
    end do
    if (i == 1 .and. present(study)) text = text//' '//study                 ! not called from a command line
    if (i == 1 .and. .not. present(study)) text = text//' run'
    if (i == 1) text = text//' '//scene%file
    if (i > 1 .and. .not. named) text = text//' ('//scene%file//')'
  end function called_as

  pure function quoted(word) result(text)
    !! Quote a word for a shell.
    character(*), intent(in) :: word
    character(:), allocatable :: text
    text = word
    if (scan(word, ' ''"$\*?;&|<>()') > 0 .or. len(word) == 0) text = "'"//replaced(word, "'", "'\''")//"'"
  end function quoted

  function time_stamp() result(text)
    !! Return the present time, ISO 8601.
    character(:), allocatable :: text
    character(8) :: date
    character(10) :: time
    character(5) :: zone
    call date_and_time(date, time, zone)
    text = date(1:4)//'-'//date(5:6)//'-'//date(7:8)//'T'//time(1:2)//':'//time(3:4)//':'//time(5:6)// &
      zone(1:3)//':'//zone(4:5)
  end function time_stamp

end module bw_result_header
