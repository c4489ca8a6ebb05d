module bw_scene_unknowns
  !! `&identify` groups as unknowns: the numbers of a scene that they name, and the scene with other values of them. An
  !! unknown is treated as a sweep of one value that changes: cases of the scene are built from it in the usual way.
  use bw_error, only: error_type
  use bw_identify_par, only: identify_par, logarithmic_from, most_unknowns
  use bw_input_name, only: accepted_text, in_range, input_name, place_of
  use bw_input_table, only: name_table
  use bw_input_values, only: group_values, positions_of
  use bw_kinds, only: dp, i8
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_scene, check_corners
  use bw_scene_messages, only: message_list
  use bw_scene_sweeps, only: excuse_missing
  use bw_sweep_par, only: sweep_par
  use bw_sweep_target, only: find_target, sweep_target
  use bw_text, only: lower, text_of
  implicit none (type, external)
  private
  public :: check_ranges, extract_unknowns, find_unknown, scene_with, with_unknowns

contains

  pure subroutine extract_unknowns(groups, sweeps, unknowns, messages)
    !! Find the numbers that `&identify` groups name; they count as given afterwards.
    type(group_values), intent(inout) :: groups(:)
    type(sweep_par), intent(in) :: sweeps(:)             !! beside unknowns: repeats of a record, or columns of a `&design`
    type(identify_par), allocatable, intent(out) :: unknowns(:)
    type(message_list), intent(inout) :: messages
    integer, allocatable :: places(:)
    integer :: i
    places = positions_of(groups, 'identify')
    allocate (unknowns(size(places)))
    if (size(places) > most_unknowns) then
      call messages%add(groups(places(most_unknowns + 1))%line, '&identify', 'is one of '//text_of(size(places))// &
                        '; accepted: at most '//text_of(most_unknowns))
      return
    end if
    if (size(places) > 0 .and. .not. all(sweeps%implied .or. sweeps%designed)) &
      call messages%add(groups(places(1))%line, '&identify', &
      'excludes &sweep: all records are fitted together; accepted: one or the other')
    do i = 1, size(places)
      if (.not. groups(places(i))%known('parameter')) cycle
      call find_unknown(groups(places(i)), groups, unknowns(i), messages)
      if (unknowns(i)%group == 0) cycle
      call check_once(groups(places(i)), unknowns(:i), messages)
      call check_range(groups(places(i)), unknowns(i), name_table(groups(unknowns(i)%group)%values(unknowns(i)%value)%row), &
                       messages)
      call give_start(groups(places(i)), groups(unknowns(i)%group), unknowns(i))
    end do
  end subroutine extract_unknowns

  pure subroutine find_unknown(source, groups, unknown, messages)
    !! Find the number that an `&identify` names in its own scene or another; none, with a message, if the number cannot
    !! be an unknown.
    type(group_values), intent(in) :: source
    type(group_values), intent(inout) :: groups(:)
    type(identify_par), intent(out) :: unknown
    type(message_list), intent(inout) :: messages
    type(sweep_target) :: target
    character(:), allocatable :: problem
    call find_target('identify', source%text('parameter'), groups, target, problem)
    unknown%parameter = lower(source%text('parameter'))
    unknown%unit = ''
    if (problem /= '') then
      call messages%add(source%line_of('parameter'), 'identify%parameter', problem)
      call excuse_missing(unknown%parameter, groups)
      return
    end if
    unknown%parameter = target%place
    unknown%group = target%group
    unknown%value = target%value
    unknown%element = target%element
    unknown%unit = trim(name_table(groups(target%group)%values(target%value)%row)%unit)
    unknown%first = source%number('first')
    unknown%last = source%number('last')
    unknown%start = 0.5_dp*unknown%first + 0.5_dp*unknown%last
    unknown%logarithmic = unknown%first > 0.0_dp .and. unknown%last/logarithmic_from >= unknown%first
    if (unknown%logarithmic) unknown%start = sqrt(unknown%first)*sqrt(unknown%last)
  end subroutine find_unknown

  pure subroutine check_once(source, unknowns, messages)
    !! Report if the last unknown repeats an earlier one.
    type(group_values), intent(in) :: source
    type(identify_par), intent(in) :: unknowns(:)
    type(message_list), intent(inout) :: messages
    integer :: i, n
    n = size(unknowns)
    do i = 1, n - 1
      if (unknowns(i)%group == 0 .or. unknowns(i)%parameter /= unknowns(n)%parameter) cycle
      call messages%add(source%line_of('parameter'), 'identify%parameter', "'"//unknowns(n)%parameter// &
                        "' is identified twice; accepted: each name once")
      return
    end do
  end subroutine check_once

  pure subroutine check_range(source, unknown, row, messages)
    !! Check that the name itself would accept both ends of the range.
    type(group_values), intent(in) :: source
    type(identify_par), intent(in) :: unknown
    type(input_name), intent(in) :: row
    type(message_list), intent(inout) :: messages
    character(5), parameter :: names(2) = [character(5) :: 'first', 'last']
    real(dp) :: ends(2)
    integer :: i
    ends = [unknown%first, unknown%last]
    do i = 1, size(names)
      if (.not. source%known(trim(names(i))) .or. in_range(row%range, ends(i))) cycle
      call messages%add(source%line_of(trim(names(i))), 'identify%'//trim(names(i)), text_of(ends(i))// &
                        ' is not accepted for '//place_of(row)//'; accepted: '//accepted_text(row))
    end do
  end subroutine check_range

  pure subroutine give_start(source, group, unknown)
    !! Set the start: the value of the scene if it lies in the range, else the middle of the range.
    type(group_values), intent(in) :: source
    type(group_values), intent(inout) :: group
    type(identify_par), intent(inout) :: unknown
    associate (value => group%values(unknown%value))
      if (value%given .and. allocated(value%numbers)) then
        associate (number => value%numbers(unknown%element))
          if (number >= unknown%first .and. number <= unknown%last) unknown%start = number
        end associate
      else
        value%given = .true.
        value%known = source%known('first') .and. source%known('last')
        value%line = source%line_of('parameter')
        call value%set_numbers([unknown%start], value%line)
      end if
      if (value%known) value%numbers(unknown%element) = unknown%start
    end associate
  end subroutine give_start

  pure subroutine with_unknowns(scene, unknowns, varied)
    !! Make a scene whose cases have other values of the unknowns; of several repeats of a record it is the first.
    type(scene_type), intent(in) :: scene                !! without sweeps
    type(identify_par), intent(in) :: unknowns(:)        !! those of group 0 belong to another scene
    type(scene_type), intent(out) :: varied
    type(sweep_par), allocatable :: sweeps(:)
    integer :: i, g, v
    varied = scene
    do g = 1, size(varied%groups)
      do v = 1, size(varied%groups(g)%values)
        associate (value => varied%groups(g)%values(v))
          if (allocated(value%sweeps)) value%sweeps = 0
        end associate
      end do
    end do
    allocate (sweeps(size(unknowns)))
    do i = 1, size(unknowns)
      sweeps(i)%parameter = unknowns(i)%parameter
      sweeps(i)%spacing = ''
      sweeps(i)%values = [unknowns(i)%start]
      sweeps(i)%axis = i
      if (unknowns(i)%group == 0) cycle
      varied%groups(unknowns(i)%group)%values(unknowns(i)%value)%sweeps(unknowns(i)%element) = i
    end do
    call move_alloc(sweeps, varied%sweeps)
  end subroutine with_unknowns

  pure subroutine scene_with(varied, values, one, error)
    !! Build the scene with these values of its unknowns. What does not change is not built again.
    type(scene_type), intent(inout) :: varied            !! by `with_unknowns`
    real(dp), intent(in) :: values(:)                    !! (unknowns)
    type(scene_type), intent(inout) :: one               !! empty, or the scene with other values
    type(error_type), allocatable, intent(out) :: error  !! these values are inconsistent
    integer :: i
    do i = 1, size(values)
      varied%sweeps(i)%values(1) = values(i)
    end do
    call case_scene(varied, 1_i8, one, error)
  end subroutine scene_with

  pure subroutine check_ranges(scene, messages)
    !! Check the scenes in which every unknown is at an end of its range: everything checked is monotone in each of them.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    type(scene_type) :: varied, one
    type(error_type), allocatable :: error
    integer :: i
    if (size(scene%unknowns) == 0) return
    call case_scene(scene, 1_i8, one, error)
    if (allocated(error)) return                         ! reported before
    call with_unknowns(one, scene%unknowns, varied)
    do i = 1, size(scene%unknowns)
      varied%sweeps(i)%values = [scene%unknowns(i)%first, scene%unknowns(i)%last]
    end do
    call check_corners(varied, messages)
  end subroutine check_ranges

end module bw_scene_unknowns
