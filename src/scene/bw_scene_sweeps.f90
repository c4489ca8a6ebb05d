module bw_scene_sweeps
  !! `&sweep` groups as sweeps: the numbers that they vary, and checks of each value.
  use bw_input_name, only: accepted_text, in_range, input_name, integer_input, is_sweepable, place_of
  use bw_input_table, only: closest, group_row, name_table
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_scene_checks, only: check_group
  use bw_scene_messages, only: message_list
  use bw_sweep_par, only: build_sweep, sweep_lines, sweep_par
  use bw_sweep_target, only: find_target, sweep_target
  use bw_text, only: lower, text_of
  implicit none (type, external)
  private
  public :: accepts, add_repeats, excuse_missing, extract_sweeps, groups_where

  real(dp), parameter :: most_cases = 1e9_dp   !! in the product of all sweeps

contains

  pure subroutine extract_sweeps(groups, sweeps, messages)
    !! Take the `&sweep` groups out of a scene; the names that they vary count as given afterwards.
    type(group_values), allocatable, intent(inout) :: groups(:)
    type(sweep_par), allocatable, intent(out) :: sweeps(:)
    type(message_list), intent(inout) :: messages
    type(group_values), allocatable :: sources(:), remaining(:)
    integer :: i
    sources = groups_where(groups, groups%group == 'sweep')
    remaining = groups_where(groups, groups%group /= 'sweep')
    call move_alloc(remaining, groups)
    allocate (sweeps(size(sources)))
    do i = 1, size(sweeps)
      call apply_sweep(sources(i), i, groups, sweeps(i), messages)
    end do
    call check_case_count(sources, sweeps, messages)
  end subroutine extract_sweeps

  pure subroutine add_repeats(groups, sweeps)
    !! Make several files of a record into cases: a sweep over their numbers, which varies fastest.
    type(group_values), intent(inout) :: groups(:)
    type(sweep_par), allocatable, intent(inout) :: sweeps(:)
    type(sweep_par), allocatable :: more(:)
    integer :: g, n, i
    g = position_of(groups, 'record')
    if (g == 0) return
    associate (file => groups(g)%values(groups(g)%at('file')))
      if (.not. file%known .or. groups(g)%count_of('file') < 2) return
      n = size(sweeps)
      allocate (more(n + 1))
      more(:n) = sweeps
      more(n + 1)%parameter = 'record%file'
      more(n + 1)%spacing = ''
      more(n + 1)%values = [(real(i, dp), i=1, size(file%texts))]
      more(n + 1)%implied = .true.
      more(n + 1)%axis = 1
      if (n > 0) more(n + 1)%axis = sweeps(n)%axis + 1
      call move_alloc(more, sweeps)
      file%sweeps(1) = n + 1
      file%numbers(1) = 1.0_dp
    end associate
  end subroutine add_repeats

  pure function groups_where(groups, mask) result(picked)
    !! Return the groups for which the mask is true.
    type(group_values), intent(in) :: groups(:)
    logical, intent(in) :: mask(:)
    type(group_values), allocatable :: picked(:)
    integer :: i, n
    allocate (picked(count(mask)))
    n = 0
    do i = 1, size(groups)
      if (.not. mask(i)) cycle
      n = n + 1
      picked(n) = groups(i)
    end do
  end function groups_where

  pure subroutine apply_sweep(source, number, groups, sweep, messages)
    !! Check one `&sweep`, and set the number that it varies to its first value.
    type(group_values), intent(in) :: source
    integer, intent(in) :: number                     !! index of the sweep
    type(group_values), intent(inout) :: groups(:)
    type(sweep_par), intent(out) :: sweep
    type(message_list), intent(inout) :: messages
    type(sweep_target) :: target
    character(:), allocatable :: problem
    integer :: before
    before = messages%count
    allocate (sweep%values(0))
    call check_group(source, messages)
    if (.not. source%known('parameter')) return
    call find_target('sweep', source%text('parameter'), groups, target, problem)
    if (problem /= '') then
      call messages%add(source%line_of('parameter'), 'sweep%parameter', problem)
      call excuse_missing(lower(source%text('parameter')), groups)
      return
    end if
    associate (value => groups(target%group)%values(target%value))
      if (.not. any(source%values%given .and. .not. source%values%known) .and. messages%count == before) then
        call build_sweep(source, sweep)
        sweep%parameter = target%place
        call check_values(source, sweep, name_table(value%row), messages)
      end if
      sweep%axis = number
      call value%follow(target%element, number, source%line_of('parameter'), sweep%values, messages%count == before)
    end associate
  end subroutine apply_sweep

  pure subroutine excuse_missing(parameter, groups)
    !! Excuse the input that an invalid sweep parameter likely meant, so that no second message reports it missing. If no
    !! name of the group is near, excuse all its required names.
    character(*), intent(in) :: parameter
    type(group_values), intent(inout) :: groups(:)
    character(:), allocatable :: group, name
    integer :: g, v
    group = parameter(:max(0, scan(parameter, '(%.:/ ') - 1))
    name = parameter(scan(parameter, '%.:/ ', back=.true.) + 1:)
    do g = 1, size(groups)
      v = groups(g)%at(name)
      if (v == 0 .and. groups(g)%group == group) v = closest(name, groups(g)%values%name)
      if (v > 0) then
        if (is_sweepable(name_table(groups(g)%values(v)%row))) groups(g)%values(v)%given = .true.
      else if (groups(g)%group == group .or. group_row(group) == 0) then
        where (name_table(groups(g)%values%row)%required) groups(g)%values%given = .true.
      end if
    end do
  end subroutine excuse_missing

  pure subroutine check_values(source, sweep, row, messages)
    !! Check that the name itself would accept each value.
    type(group_values), intent(in) :: source
    type(sweep_par), intent(in) :: sweep
    type(input_name), intent(in) :: row
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: place
    integer, allocatable :: lines(:)
    integer :: i
    place = '&sweep'
    if (sweep%spacing == '') place = 'sweep%values'
    lines = sweep_lines(source, size(sweep%values))
    do i = 1, size(sweep%values)
      if (accepts(row, sweep%values(i))) cycle
      call messages%add(lines(i), place, text_of(sweep%values(i))//' is not accepted for '//place_of(row)// &
                        '; accepted: '//accepted_text(row))
      if (sweep%spacing /= '') return                ! the other values follow from the same three numbers
    end do
  end subroutine check_values

  elemental logical function accepts(row, value)
    !! Return whether the name would accept the number.
    type(input_name), intent(in) :: row
    real(dp), intent(in) :: value
    accepts = in_range(row%range, value) .and. (row%kind /= integer_input .or. value == aint(value))
  end function accepts

  pure subroutine check_case_count(sources, sweeps, messages)
    !! Check that the number of cases is within its limit.
    type(group_values), intent(in) :: sources(:)
    type(sweep_par), intent(in) :: sweeps(:)
    type(message_list), intent(inout) :: messages
    real(dp) :: cases
    integer :: i
    cases = 1.0_dp
    do i = 1, size(sweeps)
      cases = cases*max(1, size(sweeps(i)%values))
      if (cases <= most_cases) cycle
      call messages%add(sources(i)%line, '&sweep', 'brings the product of the sweeps to '//text_of(cases)// &
                        ' cases; accepted: at most '//text_of(most_cases))
      return
    end do
  end subroutine check_case_count

end module bw_scene_sweeps
