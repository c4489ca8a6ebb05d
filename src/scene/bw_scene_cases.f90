module bw_scene_cases
  !! The cases of a scene with sweeps: the product of its axes, the first varying slowest. A `&sweep` is an axis by itself; the
  !! columns of a `&design` share one, along its rows.
  use bw_error, only: error_type, fail, status_bad_input, status_fault
  use bw_input_values, only: input_value, position_of
  use bw_kinds, only: i8
  use bw_scene, only: converges_in_run, scene_type
  use bw_scene_groups, only: build_scene, complete_groups
  use bw_scene_checks, only: check_case
  use bw_scene_messages, only: message_list
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: case_count, case_positions, case_scene, case_words, check_corners, complete, few_corners, times_in_a_row

  integer, parameter :: most_free_ends = 12       !! sweeps whose ends are combined in all ways; limits the work of a check

contains

  pure integer(i8) function case_count(scene)
    !! Count the cases, 1 without sweeps.
    type(scene_type), intent(in) :: scene
    case_count = product(int(axis_lengths(scene), i8))
  end function case_count

  pure function axis_lengths(scene) result(lengths)
    !! Return the number of places along each axis, (axes).
    type(scene_type), intent(in) :: scene
    integer, allocatable :: lengths(:)
    integer :: i
    allocate (lengths(maxval([0, scene%sweeps%axis])))
    do i = 1, size(scene%sweeps)
      lengths(scene%sweeps(i)%axis) = size(scene%sweeps(i)%values)
    end do
  end function axis_lengths

  pure function case_positions(scene, index) result(positions)
    !! Return the index of each sweep's value in a case, (n_sweeps).
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: index              !! 1 … case_count(scene)
    integer :: positions(size(scene%sweeps))
    integer, allocatable :: places(:)             ! along each axis
    integer(i8) :: remainder
    integer :: i, n
    remainder = index - 1
    places = axis_lengths(scene)
    do i = size(places), 1, -1
      n = places(i)
      places(i) = 1 + int(mod(remainder, int(n, i8)))
      remainder = remainder/n
    end do
    positions = places(scene%sweeps%axis)
  end function case_positions

  pure integer function times_in_a_row(scene, sweep) result(cases)
    !! Return for how many consecutive cases a sweep keeps its value.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: sweep                  !! index of the sweep
    integer, allocatable :: lengths(:)
    lengths = axis_lengths(scene)
    cases = product(lengths(scene%sweeps(sweep)%axis + 1:))
  end function times_in_a_row

  pure subroutine case_scene(scene, index, one, error)
    !! Build the scene of one case, without sweeps. Only components that a sweep changes are built again. The scales of all
    !! cases were checked when the scene was read: at the corners of its sweeps, unless these are too many, or for each row of
    !! its design.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: index              !! 1 … case_count(scene)
    type(scene_type), intent(inout) :: one
      !! empty, or another case of this scene, which is changed into this one; invalid after an error
    type(error_type), allocatable, intent(out) :: error
      !! `status_bad_input` if this combination of values is inconsistent
    type(message_list) :: messages
    if (index < 1 .or. index > case_count(scene)) then
      call fail(error, status_fault, scene%file//': there is no case '//text_of(index))
      return
    end if
    messages%file = scene%file
    call set_case(scene, case_positions(scene, index), one, messages)
    if (size(axis_lengths(scene)) > most_free_ends) then
      messages%case = case_words(scene, index)
      if (messages%count == 0) call check_case(one, messages)
    end if
    if (messages%count > 0) call fail(error, status_bad_input, messages%text())
  end subroutine case_scene

  pure subroutine set_case(scene, positions, one, messages)
    !! Put the values of one case in their places.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: positions(:)           !! (n_sweeps)
    type(scene_type), intent(inout) :: one        !! as in `case_scene`
    type(message_list), intent(inout) :: messages
    integer :: g, before
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
    before = messages%count
    call complete_groups(one%groups, messages)
    if (messages%count == before) call build_scene(one, messages)
  end subroutine set_case

  pure logical function differs(scene, given, positions, values)
    !! Return whether a swept number of a group has changed in any bit, the sign of zero included.
    type(scene_type), intent(in) :: scene
    type(input_value), intent(in) :: given(:)     !! for all cases
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
    !! Set the numbers of a group as they were before any was derived. Texts do not vary.
    type(scene_type), intent(in) :: scene
    type(input_value), intent(in) :: given(:)     !! for all cases
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
    !! Build the components of a scene from checked values; report what is inconsistent.
    type(scene_type), intent(inout) :: scene
    type(message_list), intent(inout) :: messages
    integer :: modes
    if (allocated(scene%design)) call enter_row_of_case(scene, 1_i8, messages)
    call complete_groups(scene%groups, messages)
    if (messages%count == 0) call build_scene(scene, messages)
    if (messages%count == 0) call check_case(scene, messages)
    call messages%leave_row()
    if (messages%count > 0) return
    modes = position_of(scene%groups, 'modes')
    if (.not. scene%modes%asked .and. (size(scene%sweeps) > 0 .or. converges_in_run(scene))) &
      & call scene%groups(modes)%drop('tolerance')          ! cases may relax it, and so may a contact of finite duration, or loads
  end subroutine complete

  pure subroutine enter_row_of_case(scene, index, messages)
    !! Attribute messages to the row of the design that gives the case.
    type(scene_type), intent(in) :: scene         !! with a design
    integer(i8), intent(in) :: index              !! of the case
    type(message_list), intent(inout) :: messages
    integer :: positions(size(scene%sweeps))
    if (size(scene%sweeps) == 0) return
    if (size(scene%sweeps(1)%values) == 0) return
    positions = case_positions(scene, index)
    call messages%enter_row(scene%design%path, scene%design%lines(positions(1)), scene%design%line)
  end subroutine enter_row_of_case

  pure subroutine check_corners(scene, messages)
    !! Check the cases at the corners. Everything checked (products, equal counts) is monotone in each input, so corners bound
    !! all cases. If sweeps are many, some are varied together; errors that these corners miss are found in the case itself.
    !! Rows of a design are checked one by one if a corner fails or corners are no fewer than rows.
    type(scene_type), intent(in) :: scene         !! with sweeps
    type(message_list), intent(inout) :: messages
    type(message_list) :: corners
    integer :: n
    n = size(scene%sweeps)
    if (.not. allocated(scene%design)) then
      call check_ends(scene, messages)
    else
      if (n <= most_free_ends .and. 2_i8**min(n, most_free_ends) < size(scene%design%lines)) then
        corners%file = scene%file
        call check_ends(scene, corners)
        if (corners%count == 0) return
      end if
      call check_rows(scene, messages)
    end if
  end subroutine check_corners

  pure subroutine check_ends(scene, messages)
    !! Check the least and the largest values of all sweeps combined, up to the first error.
    type(scene_type), intent(in) :: scene         !! with sweeps; a corner of a design need not be one of its cases
    type(message_list), intent(inout) :: messages
    type(scene_type) :: one
    integer :: ends(2, size(scene%sweeps)), positions(size(scene%sweeps)), i, k, side
    ends = sweep_ends(scene)
    do k = 0, 2**min(most_free_ends, size(scene%sweeps)) - 1
      do i = 1, size(scene%sweeps)
        side = merge(2, 1, btest(k, mod(i - 1, most_free_ends)))
        positions(i) = ends(side, i)
      end do
      messages%case = position_words(scene, positions)
      call set_case(scene, positions, one, messages)
      if (messages%count == 0) call check_case(one, messages)
      if (messages%count > 0) return
    end do
  end subroutine check_ends

  pure subroutine check_rows(scene, messages)
    !! Check one case for each row of a design, and report all errors.
    type(scene_type), intent(in) :: scene         !! with a design
    type(message_list), intent(inout) :: messages
    type(scene_type), allocatable :: one
    integer(i8) :: each, row
    integer :: before
    each = times_in_a_row(scene, 1)
    allocate (one)
    do row = 1, size(scene%design%lines)
      if (messages%cut) exit
      before = messages%count
      call enter_row_of_case(scene, 1 + (row - 1)*each, messages)
      call set_case(scene, case_positions(scene, 1 + (row - 1)*each), one, messages)
      if (messages%count == before) call check_case(one, messages)
      if (messages%count == before) cycle
      deallocate (one)                            ! invalid after an error
      allocate (one)
    end do
    call messages%leave_row()
  end subroutine check_rows

  pure function few_corners(scene) result(cases)
    !! Return the cases in which all sweeps take their least value, or all their largest, and those in which one sweep differs:
    !! all corners for up to three sweeps, and 2(n + 1) for n. For a design, return the rows in which a column has its least or
    !! largest value.
    type(scene_type), intent(in) :: scene
    integer(i8), allocatable :: cases(:)
    integer(i8) :: corner
    integer :: ends(2, size(scene%sweeps)), i, side, other
    ends = sweep_ends(scene)
    allocate (cases(0))
    if (allocated(scene%design)) then
      do i = 1, size(scene%sweeps)
        do side = 1, 2
          corner = 1 + (ends(side, i) - 1)*times_in_a_row(scene, i)
          if (scene%sweeps(i)%designed .and. all(cases /= corner)) cases = [cases, corner]
        end do
      end do
      return
    end if
    do other = 0, size(scene%sweeps)
      do side = 1, 2
        corner = corner_case(scene, ends, [((side == 2) .neqv. (i == other), i=1, size(scene%sweeps))])
        if (all(cases /= corner)) cases = [cases, corner]
      end do
    end do
  end function few_corners

  pure function sweep_ends(scene) result(ends)
    !! Return the indices of the least and the largest value of each sweep, (2, n_sweeps).
    type(scene_type), intent(in) :: scene
    integer :: ends(2, size(scene%sweeps))
    integer :: i
    do i = 1, size(scene%sweeps)
      ends(:, i) = [minloc(scene%sweeps(i)%values, dim=1), maxloc(scene%sweeps(i)%values, dim=1)]
    end do
  end function sweep_ends

  pure integer(i8) function corner_case(scene, ends, largest) result(index)
    !! Return the case in which the marked sweeps take their largest value, and the others their least.
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
    !! Return the end of a message that concerns one case.
    type(scene_type), intent(in) :: scene         !! with sweeps
    integer(i8), intent(in) :: index              !! of the case
    character(:), allocatable :: text
    integer :: positions(size(scene%sweeps))
    positions = case_positions(scene, index)
    if (allocated(scene%design)) then
      text = ' (with '//scene%design%path//':'//text_of(scene%design%lines(positions(1)))//')'
      return
    end if
    text = position_words(scene, positions)
  end function case_words

  pure function position_words(scene, positions) result(text)
    !! Return the same, given the index of each sweep's value.
    type(scene_type), intent(in) :: scene         !! with sweeps
    integer, intent(in) :: positions(:)           !! (n_sweeps)
    character(:), allocatable :: text
    integer :: i
    text = ' (in the case '
    do i = 1, size(positions)
      if (i > 1) text = text//', '
      text = text//scene%sweeps(i)%parameter//' = '//shortest(scene%sweeps(i)%values(positions(i)), 15)
    end do
    text = text//')'
  end function position_words

end module bw_scene_cases
