module scene_faults
  !! What the reader of scenes does wrong with a text, judged from outside: a scene that it accepts means what the text
  !! says and survives being written and read again; a text that it refuses gets messages with a place.
  use bw_error, only: error_type, status_bad_input
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count
  use bw_scene_reader, only: read_scene_text
  use bw_scene_resolved, only: numeric_inputs, resolved_text
  use fortran_reading, only: reading_type, compare_with_fortran
  implicit none (type, external)
  private
  public :: judge

  character, parameter :: nl = new_line('a')
  character(*), parameter :: name = 'x.nml'

contains

  subroutine judge(text, fault, resolved, reading)
    !! Read a text, and look for faults of the reader.
    character(*), intent(in) :: text
    character(:), allocatable, intent(out) :: fault      !! empty for none
    character(:), allocatable, intent(out) :: resolved   !! the resolved scene; empty where the text is refused
    type(reading_type), intent(inout) :: reading         !! counts what Fortran's own reader could tell
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    resolved = ''
    call read_scene_text(text, name, scene, error)
    if (allocated(error)) then
      fault = fault_of_message(error, text)
      return
    end if
    resolved = resolved_text(scene)
    fault = fault_of_round_trip(scene, resolved)
    if (fault == '') call compare_with_fortran(text, scene, reading, fault)
  end subroutine judge

  function fault_of_round_trip(scene, resolved) result(fault)
    !! The resolved scene is a scene, and resolves to itself.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: resolved
    character(:), allocatable :: fault
    type(scene_type) :: again
    type(error_type), allocatable :: error
    fault = 'a scene without cases or without a beam is accepted'
    if (case_count(scene) < 1 .or. size(numeric_inputs(scene)) < 5) return
    call read_scene_text(resolved, name, again, error)
    fault = 'the resolved scene is refused'
    if (allocated(error)) return
    fault = 'the resolved scene reads otherwise'
    if (resolved_text(again) == resolved) fault = ''
  end function fault_of_round_trip

  function fault_of_message(error, text) result(fault)
    !! Each line is `FILE:LINE: place: what` or `FILE: place: what`, and the line is one of the text.
    type(error_type), intent(in) :: error
    character(*), intent(in) :: text
    character(:), allocatable :: fault
    integer :: first, length
    fault = 'a refusal with another status'
    if (error%status /= status_bad_input) return
    fault = ''
    first = 1
    do while (first <= len(error%message) .and. fault == '')
      length = index(error%message(first:)//nl, nl)
      if (.not. is_located(error%message(first:first + length - 2), lines_of(text))) &
        fault = 'a message without a place: '//error%message(first:first + length - 2)
      first = first + length
    end do
  end function fault_of_message

  pure logical function is_located(message, lines)
    character(*), intent(in) :: message
    integer, intent(in) :: lines           !! of the text
    integer :: at, colon, line, stat
    is_located = .false.
    if (index(message, name//':') /= 1) return
    at = len(name) + 2
    if (message(at:at) /= ' ') then
      colon = at - 1 + index(message(at:), ':')
      if (colon < at) return
      read (message(at:colon - 1), *, iostat=stat) line
      if (stat /= 0) return
      if (line < 1 .or. line > lines) return
      at = colon + 1
    end if
    is_located = has_place(message(at:)) .and. verify(message, printable()) == 0
  end function is_located

  pure logical function has_place(rest)
    !! ` text: …`, ` &group: …` or ` group%name: …`, and then words.
    character(*), intent(in) :: rest
    integer :: colon
    colon = index(rest, ': ')
    has_place = .false.
    if (colon < 3 .or. rest(1:1) /= ' ') return
    associate (place => rest(2:colon - 1))
      has_place = place == 'text' .or. place(1:1) == '&' .or. index(place, '%') > 1
    end associate
  end function has_place

  pure function printable() result(set)
    !! All bytes but control characters.
    character(223) :: set
    integer :: i
    do i = 32, 254
      set(i - 31:i - 31) = char(i)
    end do
  end function printable

  pure integer function lines_of(text)
    character(*), intent(in) :: text
    integer :: i
    lines_of = 1 + count([(text(i:i) == nl, i=1, len(text))])
  end function lines_of

end module scene_faults
