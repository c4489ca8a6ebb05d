module bw_sweep_target
  !! Finds the number of a scene that a `&sweep`, `&design` or `&identify` names: `group%name`, or one of several as `body(2)%mass`.
  use bw_input_name, only: input_name, integer_input, is_number, is_sweepable, place_of
  use bw_input_table, only: group_row, group_table, name_row, name_table, unknown_group, unknown_name
  use bw_input_values, only: group_values, position_of, positions_of
  use bw_scene_messages, only: shown
  use bw_text, only: lower, text_of
  implicit none (type, external)
  private
  public :: find_target

  type, public :: sweep_target
    !! The number of a scene that a sweep varies, or that is unknown.
    integer :: group = 0                         !! place of its group; 0: none found
    integer :: value = 0                         !! place of its name in the group
    integer :: element = 1                       !! index among the numbers of the name
    character(:), allocatable :: place           !! as a sweep names it, with numbers only if there are several
  end type sweep_target

contains

  pure subroutine find_target(by, named, groups, target, problem)
    !! Find the number that a sweep varies; if it cannot, return none and the reason.
    character(*), intent(in) :: by                   !! `sweep`, `design`, or `identify`, which accepts fewer
    character(*), intent(in) :: named                !! as the user wrote it
    type(group_values), intent(in) :: groups(:)
    type(sweep_target), intent(out) :: target
    character(:), allocatable, intent(out) :: problem   !! empty: none
    character(:), allocatable :: parameter, group, name
    integer :: mark, group_number, name_number
    parameter = lower(named)
    mark = index(parameter, '%')
    call split(parameter(:mark - 1), group, group_number)
    call split(parameter(mark + 1:), name, name_number)
    if (index(parameter, '&') == 1) then
      problem = "begins with &; accepted: '"//parameter(2:)//"'"
    else if (mark == 0 .or. scan(parameter, ' ') > 0) then
      problem = "names no input"//likely_target(by, parameter, groups)//"; accepted: 'group%name'"
    else if (group_row(group) == 0) then
      problem = 'group '//unknown_group(group)
    else if (name_row(group, name) == 0) then
      problem = unknown_name(group, name, to_sweep=.true.)
    else
      problem = obstacle(by, name_table(name_row(group, name)), groups)
      if (problem == '') call resolve(by, groups, name_table(name_row(group, name)), group_number, name_number, target, problem)
    end if
    if (problem == '') return
    target = sweep_target()
    problem = shown(parameter)//' '//problem
  end subroutine find_target

  elemental logical function is_taken(by, row)
    !! Return whether a `&sweep` may vary the name or, for `&identify`, the name may be unknown: a real number of the beam.
    character(*), intent(in) :: by
    type(input_name), intent(in) :: row
    is_taken = is_sweepable(row)
    if (is_taken .and. by == 'identify') is_taken = row%kind /= integer_input .and. &
      (row%group == 'beam' .or. group_table(group_row(row%group))%is_effect)
  end function is_taken

  pure function likely_target(by, parameter, groups) result(text)
    !! Return ` (did you mean 'beam%length'?)` for a name without its group or with another separator, or nothing. Groups of the
    !! scene are preferred.
    character(*), intent(in) :: by, parameter
    type(group_values), intent(in) :: groups(:)
    character(:), allocatable :: text, name
    integer :: i
    logical :: there
    text = ''
    name = trim(parameter(scan(parameter, '.:/ ', back=.true.) + 1:))
    there = any([(name_table(i)%name == name .and. position_of(groups, trim(name_table(i)%group)) > 0, i=1, size(name_table))])
    do i = 1, size(name_table)
      if (name_table(i)%name /= name .or. .not. is_taken(by, name_table(i))) cycle
      if (there .and. position_of(groups, trim(name_table(i)%group)) == 0) cycle
      if (index(parameter, trim(name_table(i)%group)) == 0 .and. len(parameter) > len(name)) cycle
      if (text /= '') text = text//' or'
      text = text//" '"//place_of(name_table(i))//"'"
    end do
    if (text /= '') text = ' (did you mean'//text//'?)'
  end function likely_target

  pure subroutine split(word, name, number)
    !! Split `body(2)` into the name `body` and the number 2; without brackets the number is 0, without a number in them −1.
    character(*), intent(in) :: word
    character(:), allocatable, intent(out) :: name
    integer, intent(out) :: number
    integer, parameter :: most_digits = 6
    integer :: open
    name = word
    number = 0
    open = index(word, '(')
    if (open == 0) return
    name = word(:open - 1)
    number = -1
    if (word(len(word):) /= ')' .or. len(word) < open + 2 .or. len(word) > open + most_digits + 1) return
    if (verify(word(open + 1:len(word) - 1), '0123456789') > 0) return
    read (word(open + 1:len(word) - 1), *) number
    if (number == 0) number = -1
  end subroutine split

  pure subroutine resolve(by, groups, row, group_number, name_number, target, problem)
    !! Find the number of the scene that a known name refers to.
    character(*), intent(in) :: by
    type(group_values), intent(in) :: groups(:)
    type(input_name), intent(in) :: row
    integer, intent(in) :: group_number, name_number  !! as written after the group and the name; 0: none
    type(sweep_target), intent(out) :: target
    character(:), allocatable, intent(out) :: problem
    integer, allocatable :: found(:)
    problem = ''
    found = positions_of(groups, row%group)
    call choose('group', trim(row%group), '%'//trim(row%name), size(found), group_number, problem)
    if (problem /= '') return
    target%group = found(max(1, group_number))
    target%value = groups(target%group)%at(row%name)
    target%place = trim(row%group)
    if (size(found) > 1) target%place = target%place//'('//text_of(max(1, group_number))//')'
    target%place = target%place//'%'//trim(row%name)
    target%element = max(1, name_number)
    associate (value => groups(target%group)%values(target%value))
      if (name_number /= 0 .and. .not. value%given) then
        problem = "names one of several values, but none is given; accepted: '"//target%place//"'"
      else
        call choose('value', target%place, '', max(1, groups(target%group)%count_of(row%name)), name_number, problem)
      end if
      if (problem /= '') return
      if (groups(target%group)%count_of(row%name) > 1) target%place = target%place//'('//text_of(target%element)//')'
      if (.not. allocated(value%sweeps)) return
      if (value%sweeps(target%element) == 0) return
      problem = 'is swept twice; accepted: each name once'
      if (by == 'identify') problem = 'is also swept; accepted: a sweep or an unknown'
      if (by == 'design') problem = 'has two columns; accepted: each name once'
    end associate
  end subroutine resolve

  pure function obstacle(by, row, groups) result(problem)
    !! Return why a known name cannot be swept here, or be unknown; empty if it can.
    character(*), intent(in) :: by
    type(input_name), intent(in) :: row
    type(group_values), intent(in) :: groups(:)
    character(:), allocatable :: problem
    integer :: g
    g = position_of(groups, row%group)
    problem = ''
    if (.not. (is_number(row) .or. row%along /= '')) then
      problem = 'is not one number; accepted: '//sweepable_names(by)
    else if (.not. is_sweepable(row)) then
      problem = 'sets an axis of the result; accepted: '//sweepable_names(by)
    else if (.not. is_taken(by, row)) then
      problem = 'is not a real number of the beam; accepted: '//sweepable_names(by)
    else if (g == 0) then
      problem = 'belongs to a group that is absent; accepted: a scene with &'//trim(row%group)
    else if (groups(g)%line == 0) then
      problem = 'belongs to a group that is absent; accepted: a scene with &'//trim(row%group)
    end if
  end function obstacle

  pure subroutine choose(what, before, behind, count, number, problem)
    !! Report an invalid index of one of several, and the valid ones.
    character(*), intent(in) :: what                  !! what the index counts
    character(*), intent(in) :: before, behind        !! text around the index in a parameter
    integer, intent(in) :: count                      !! number of them
    integer, intent(in) :: number                     !! the index; 0: none is named
    character(:), allocatable, intent(inout) :: problem
    if (count == 1 .and. number == 0) return
    if (number >= 1 .and. number <= count) return
    if (number == 0) then
      problem = 'is one of '//text_of(count)//' '//what//'s'
    else if (number < 0) then
      problem = 'has no number of a '//what//' in its brackets'
    else if (count == 1) then
      problem = 'names '//what//' '//text_of(number)//', and there is one'
    else
      problem = 'names '//what//' '//text_of(number)//' of '//text_of(count)
    end if
    problem = problem//"; accepted: '"//before
    if (count > 1) problem = problem//'(1)'
    problem = problem//behind//"'"
    if (count > 1) problem = problem//" to '"//before//'('//text_of(count)//')'//behind//"'"
  end subroutine choose

  pure function sweepable_names(by) result(text)
    !! Return every `group%name` that a sweep may vary, or that may be unknown.
    character(*), intent(in) :: by
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(name_table)
      if (is_taken(by, name_table(i))) text = text//' '//place_of(name_table(i))
    end do
    text = text(2:)
  end function sweepable_names

end module bw_sweep_target
