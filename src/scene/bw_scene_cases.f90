module bw_scene_cases
  !! The cases of a scene with sweeps: the product of their values, the first sweep varying slowest.
  use bw_error, only: error_type, fail, status_bad_input, status_fault
  use bw_input_values, only: input_value, position_of
  use bw_kinds, only: i8
  use bw_scene, only: build_scene, complete_groups, counts_in_its_run, scene_type
  use bw_scene_checks, only: check_case
  use bw_scene_messages, only: message_list
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: case_count, case_positions, case_scene, case_words, check_corners, complete, few_corners, times_in_a_row

  integer, parameter :: most_free_ends = 12       !! sweeps whose ends are combined in all ways, so that a check has an end

contains

  pure integer(i8) function case_count(scene)
    !! Number of cases, 1 without sweeps.
    type(scene_type), intent(in) :: scene
    integer :: i
    case_count = 1
    do i = 1, size(scene%sweeps)
      case_count = case_count*size(scene%sweeps(i)%values)
    end do
  end function case_count

  pure function case_positions(scene, index) result(positions)
    !! Which value of each sweep a case has, (n_sweeps).
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: index              !! 1 … case_count(scene)
    integer :: positions(size(scene%sweeps))
    integer(i8) :: remainder
    integer :: i, n
    remainder = index - 1
    do i = size(positions), 1, -1
      n = size(scene%sweeps(i)%values)
      positions(i) = 1 + int(mod(remainder, int(n, i8)))
      remainder = remainder/n
    end do
  end function case_positions

  pure integer function times_in_a_row(scene, sweep) result(cases)
    !! In how many neighbouring cases a sweep takes the same value.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: sweep                  !! its number
    integer :: i
    cases = 1
    do i = sweep + 1, size(scene%sweeps)
      cases = cases*size(scene%sweeps(i)%values)
    end do
  end function times_in_a_row

  pure subroutine case_scene(scene, index, one, error)
    !! The scene of one case, without sweeps. Cheap: nothing is read again, what no sweep changes stays as it is, and the
    !! scales of all cases were checked at the corners of their sweeps when the scene was read, unless the sweeps are too many.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: index              !! 1 … case_count(scene)
    type(scene_type), intent(inout) :: one
      !! empty, or another case of this scene, which is turned into this one; after an error of no use
    type(error_type), allocatable, intent(out) :: error
      !! `status_bad_input` where this combination of values makes no sense
    type(message_list) :: messages
    if (index < 1 .or. index > case_count(scene)) then
      call fail(error, status_fault, scene%file//': there is no case '//text_of(index))
      return
    end if
    messages%file = scene%file
    call set_case(scene, case_positions(scene, index), one, messages)
    if (size(scene%sweeps) > most_free_ends) then
      messages%case = case_words(scene, index)
      if (messages%count == 0) call check_case(one, messages)
    end if
    if (messages%count > 0) call fail(error, status_bad_input, messages%text())
  end subroutine case_scene

  pure subroutine set_case(scene, positions, one, messages)
    !! Put the values of one case in their places.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: positions(:)           !! (n_sweeps)
    type(scene_type), intent(inout) :: one        !! as that of `case_scene`
    type(message_list), intent(inout) :: messages
    integer :: g
    if (.not. allocated(one%groups)) then
      one%file = scene%file
      one%name = scene%name
      one%groups = scene%groups
      if (allocated(scene%unknowns)) one%unknowns = scene%unknowns
      allocate (one%sweeps(0))
    else
      do g = 1, size(one%groups)
        one%groups(g)%changed = differs(scene, scene%groups(g)%values, positions, one%groups(g)%values)
      end do
    end if
    do g = 1, size(one%groups)
      if (one%groups(g)%changed) call set_values(scene, scene%groups(g)%values, positions, one%groups(g)%values)
    end do
    call build(one, messages)
  end subroutine set_case

  pure logical function differs(scene, given, positions, values)
    !! Some swept number of a group is not what it was, to the bit: zeros have signs.
    type(scene_type), intent(in) :: scene
    type(input_value), intent(in) :: given(:)     !! of all cases
    integer, intent(in) :: positions(:)
    type(input_value), intent(in) :: values(:)    !! of another case
    integer :: v, i
    differs = .false.
    do v = 1, size(given)
      if (.not. allocated(given(v)%sweeps)) cycle
      do i = 1, size(given(v)%sweeps)
        if (given(v)%sweeps(i) == 0) cycle
        associate (number => scene%sweeps(given(v)%sweeps(i))%values(positions(given(v)%sweeps(i))))
          differs = transfer(number, 0_i8) /= transfer(values(v)%numbers(i), 0_i8)
        end associate
        if (differs) return
      end do
    end do
  end function differs

  pure subroutine set_values(scene, given, positions, values)
    !! The numbers of a group, as they were before any was derived. Texts are those of all cases.
    type(scene_type), intent(in) :: scene
    type(input_value), intent(in) :: given(:)     !! of all cases
    integer, intent(in) :: positions(:)
    type(input_value), intent(inout) :: values(:)
    integer :: v, i
    do v = 1, size(values)
      values(v)%known = given(v)%known
      values(v)%redundant = given(v)%redundant
      if (.not. allocated(given(v)%numbers)) cycle
      do i = 1, size(given(v)%numbers)
        values(v)%sweeps(i) = 0
        values(v)%numbers(i) = given(v)%numbers(i)
        if (given(v)%sweeps(i) > 0) values(v)%numbers(i) = scene%sweeps(given(v)%sweeps(i))%values(positions(given(v)%sweeps(i)))
      end do
    end do
  end subroutine set_values

  pure subroutine complete(scene, messages)
    !! From checked values to the components of a scene; report what does not fit together.
    type(scene_type), intent(inout) :: scene
    type(message_list), intent(inout) :: messages
    integer :: modes
    call build(scene, messages)
    if (messages%count > 0) return
    call check_case(scene, messages)
    modes = position_of(scene%groups, 'modes')
    if (.not. scene%modes%asked .and. (size(scene%sweeps) > 0 .or. counts_in_its_run(scene))) &
      & call scene%groups(modes)%drop('tolerance')          ! cases may relax it, and so may a contact that lasts, or loads
  end subroutine complete

  pure subroutine build(scene, messages)
    !! The same without a look at the scales.
    type(scene_type), intent(inout) :: scene
    type(message_list), intent(inout) :: messages
    call complete_groups(scene%groups, messages)
    if (messages%count == 0) call build_scene(scene, messages)
  end subroutine build

  pure subroutine check_corners(scene, messages)
    !! Check the cases at the corners. What is checked of a case (products, equal counts) is monotone in each input, so that
    !! these stand for all. Of many sweeps some take their ends together; what these corners miss is found in the case itself.
    type(scene_type), intent(in) :: scene         !! with sweeps
    type(message_list), intent(inout) :: messages
    type(scene_type) :: one
    integer(i8) :: corner
    integer :: ends(2, size(scene%sweeps)), i, k, free
    ends = sweep_ends(scene)
    free = min(most_free_ends, size(scene%sweeps))
    do k = 0, 2**free - 1
      corner = corner_case(scene, ends, [(btest(k, mod(i - 1, most_free_ends)), i=1, size(scene%sweeps))])
      messages%case = case_words(scene, corner)
      call set_case(scene, case_positions(scene, corner), one, messages)
      if (messages%count == 0) call check_case(one, messages)
      if (messages%count > 0) return
    end do
  end subroutine check_corners

  pure function few_corners(scene) result(cases)
    !! The cases in which every sweep takes its least value, or every one its largest, and those in which one sweep does not: of up
    !! to three sweeps all corners, and of many no more than twice their number.
    type(scene_type), intent(in) :: scene
    integer(i8), allocatable :: cases(:)
    integer(i8) :: corner
    integer :: ends(2, size(scene%sweeps)), i, side, other
    ends = sweep_ends(scene)
    allocate (cases(0))
    do other = 0, size(scene%sweeps)
      do side = 1, 2
        corner = corner_case(scene, ends, [((side == 2) .neqv. (i == other), i=1, size(scene%sweeps))])
        if (all(cases /= corner)) cases = [cases, corner]
      end do
    end do
  end function few_corners

  pure function sweep_ends(scene) result(ends)
    !! Which value of each sweep is its least, and which its largest, (2, n_sweeps).
    type(scene_type), intent(in) :: scene
    integer :: ends(2, size(scene%sweeps))
    integer :: i
    do i = 1, size(scene%sweeps)
      ends(:, i) = [minloc(scene%sweeps(i)%values, dim=1), maxloc(scene%sweeps(i)%values, dim=1)]
    end do
  end function sweep_ends

  pure integer(i8) function corner_case(scene, ends, largest) result(index)
    !! The case in which these sweeps take their largest value, and the others their least.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: ends(:, :)             !! of the sweeps
    logical, intent(in) :: largest(:)             !! (n_sweeps)
    integer :: i
    index = 1
    do i = 1, size(scene%sweeps)
      index = (index - 1)*size(scene%sweeps(i)%values) + merge(ends(2, i), ends(1, i), largest(i))
    end do
  end function corner_case

  pure function case_words(scene, index) result(text)
    !! How a message ends that holds for one case.
    type(scene_type), intent(in) :: scene         !! with sweeps
    integer(i8), intent(in) :: index              !! of the case
    character(:), allocatable :: text
    integer :: positions(size(scene%sweeps)), i
    positions = case_positions(scene, index)
    text = ' (in the case '
    do i = 1, size(positions)
      if (i > 1) text = text//', '
      text = text//scene%sweeps(i)%parameter//' = '//shortest(scene%sweeps(i)%values(positions(i)), 15)
    end do
    text = text//')'
  end function case_words

end module bw_scene_cases
