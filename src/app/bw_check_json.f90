module bw_check_json
  !! The output of `beamwave check --json`: one document, with an object for each scene.
  use bw_json, only: json_list, json_member, json_number, json_text, json_texts
  use bw_kinds, only: dp, i8
  use bw_missing, only: missing
  use bw_modes_par, only: by_tolerance
  use bw_note, only: is_remark, kind_of, unmarked
  use bw_result_header, only: source_text
  use bw_result_layout, only: result_layout
  use bw_scene, only: effect_names, method_name, scene_type
  use bw_scene_tally, only: without_case
  use bw_text, only: append, lines_of, string, text_of, words_of
  implicit none (type, external)
  private
  public :: check_document, good_scene, refused_scene

  type, public :: scene_facts
    !! The properties of a valid scene.
    integer :: modes = 0                           !! to be summed; 0: known only to a run
    integer(i8) :: memory = 0, disk = 0            !! bytes that a run needs
    real(dp) :: seconds = missing                  !! of a run on one core
    character(:), allocatable :: notes             !! lines
  end type scene_facts

  character(*), parameter :: nl = new_line('a'), digits = '0123456789'

contains

  function check_document(scenes, status) result(document)
    !! Return the whole document, with a line for each scene.
    type(string), intent(in) :: scenes(:)          !! objects
    integer, intent(in) :: status                  !! of the command
    character(:), allocatable :: document
    type(string) :: rows(size(scenes))
    integer :: i
    do i = 1, size(scenes)
      rows(i)%text = nl//'  '//scenes(i)%text
    end do
    document = '{"program": '//json_text(source_text())//json_member('status', text_of(status))// &
      json_member('scenes', json_list(rows))//'}'//nl
  end function check_document

  function good_scene(scene, layout, facts) result(object)
    !! Return the object of a valid scene.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(scene_facts), intent(in) :: facts
    character(:), allocatable :: object, modes, tolerance
    modes = 'null'
    tolerance = 'null'
    if (.not. layout%of_record) then
      if (by_tolerance(scene%modes)) tolerance = json_number(scene%modes%tolerance)
      if (facts%modes > 0) modes = text_of(facts%modes)
    end if
    object = '{"file": '//json_text(scene%file)//json_member('status', '0')// &
      json_member('title', json_text(scene%header%title))// &
      json_member('cases', text_of(max(1, layout%cases)))// &
      json_member('method', json_text(method_name(scene)))// &
      json_member('effects', json_texts(words_of(effect_names(scene))))// &
      json_member('modes', modes)//json_member('tolerance', tolerance)// &
      json_member('points', text_of(layout%points))//json_member('samples', text_of(layout%samples))// &
      json_member('memory_bytes', text_of(facts%memory))//json_member('disk_bytes', text_of(facts%disk))// &
      json_member('seconds', json_number(facts%seconds))//json_member('errors', '[]')// &
      json_member('warnings', notes_of(facts%notes, .false.))//json_member('remarks', notes_of(facts%notes, .true.))//'}'
  end function good_scene

  pure function notes_of(notes, remarks) result(list)
    !! Return the warnings among notes, or the remarks.
    character(*), intent(in) :: notes              !! lines
    logical, intent(in) :: remarks
    character(:), allocatable :: list
    type(string), allocatable :: lines(:), objects(:)
    integer :: i
    allocate (objects(0))
    lines = lines_of(notes)
    do i = 1, size(lines)
      if (is_remark(lines(i)%text) .neqv. remarks) cycle
      call append(objects, '{"kind": '//json_text(kind_of(without_case(lines(i)%text)))// &
                  json_member('message', json_text(unmarked(lines(i)%text)))//'}')
    end do
    list = json_list(objects)
  end function notes_of

  pure function refused_scene(file, status, message) result(object)
    !! Return the object of a scene that cannot be read or is wrong.
    character(*), intent(in) :: file
    integer, intent(in) :: status                  !! 2, 3 or 4
    character(*), intent(in) :: message            !! all errors, each as `FILE:LINE: group%name: what`
    character(:), allocatable :: object, rest
    type(string), allocatable :: objects(:)
    integer :: last
    allocate (objects(0))
    rest = message
    do while (rest /= '')
      last = error_length(file, rest)
      call append(objects, error_object(file, rest(:last)))
      rest = rest(last + 2:)
    end do
    object = '{"file": '//json_text(file)//json_member('status', text_of(status))// &
      json_member('errors', json_list(objects))//json_member('warnings', '[]')//json_member('remarks', '[]')//'}'
  end function refused_scene

  pure integer function error_length(file, text) result(length)
    !! Return the length of the first error of a text: the next one begins on a new line, with the scene's file or another place.
    character(*), intent(in) :: file, text
    integer :: next
    length = 0
    if (index(text, file//':') == 1) length = len(file)
    do
      next = index(text(length + 1:), nl)
      if (next == 0) exit
      length = length + next
      if (index(text(length + 1:), file//':') == 1 .or. line_mark(text(length + 1:)) > 0) then
        length = length - 1
        return
      end if
    end do
    length = len(text)
  end function error_length

  pure integer function line_mark(text) result(colon)
    !! Return the end of the path in a text `PATH:LINE: …`; 0 if its first line has none.
    character(*), intent(in) :: text
    integer :: next, last
    last = index(text//nl, nl) - 1
    colon = index(text(:last), ':')
    do while (colon > 0)
      next = verify(text(colon + 1:last), digits)
      if (next > 1) then
        if (text(colon + next:min(last, colon + next + 1)) == ': ') return
      end if
      next = index(text(colon + 1:last), ':')
      if (next == 0) colon = 0
      if (next > 0) colon = colon + next
    end do
  end function line_mark

  pure function error_object(file, message) result(object)
    !! Split `FILE:LINE: group%name: what`; missing parts are null, and the default file is the scene's.
    character(*), intent(in) :: file, message
    character(:), allocatable :: object
    character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz_()%&'//digits
    character(:), allocatable :: group, line, name, path, what
    integer :: colon, percent
    path = file
    line = 'null'
    group = 'null'
    name = 'null'
    what = message
    if (index(what, file//':') /= 1 .and. line_mark(what) > 0) path = what(:line_mark(what) - 1)
    if (index(what, path//':') == 1) what = what(len(path) + 2:)
    colon = index(what, ':')
    if (colon > 1) then
      if (verify(what(:colon - 1), digits) == 0) then
        line = what(:colon - 1)
        what = what(colon + 1:)
      end if
    end if
    what = trim(adjustl(what))
    colon = index(what, ': ')
    percent = index(what(:max(0, colon - 1)), '%')
    if (colon > 1 .and. verify(what(:max(0, colon - 1)), letters) == 0 .and. (percent > 1 .or. index(what, '&') == 1)) then
      if (percent > 1) then
        group = json_text(what(:percent - 1))
        name = json_text(what(percent + 1:colon - 1))
      else
        group = json_text(what(2:colon - 1))
      end if
      what = what(colon + 2:)
    end if
    object = '{"file": '//json_text(path)//json_member('line', line)//json_member('group', group)//json_member('name', name)// &
      json_member('message', json_text(what))//'}'
  end function error_object

end module bw_check_json
