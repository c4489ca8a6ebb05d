module bw_scene_resolved
  !! The resolved scene: the namelist with defaults and derived values filled in, and its numbers one by one.
  !! Saved to a file and read again, it gives the same values bit for bit.
  use bw_input_name, only: columns_input, input_name, integer_input, is_number, logical_input, name_length, reals_input, &
                           text_input, texts_input
  use bw_input_table, only: group_table, name_table
  use bw_input_values, only: group_values, input_value, positions_of
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_scene, only: scene_type
  use bw_shear_par, only: usual_coefficient
  use bw_sweep_par, only: sweep_par
  use bw_text, only: replaced, text_builder, text_of
  implicit none (type, external)
  private
  public :: given_names, numeric_inputs, resolved_text, values_of_sweep

  type, public :: numeric_input
    !! A number, or several along a dimension, of the resolved scene.
    character(name_length) :: group = '', name = ''
    character(12) :: unit = ''           !! as UDUNITS writes it
    character(80) :: meaning = ''
    logical :: is_integer = .false.
    character(8) :: dimension = ''       !! along which several lie; '' for one number
    logical :: is_swept = .false.        !! some of its numbers have `values_of_sweep`
    real(dp), allocatable :: values(:)   !! in every case, or in the first if swept; missing if not given, (n)
    integer, allocatable :: sweeps(:)    !! the sweep that each follows; 0: none, (n)
  end type numeric_input

  integer, parameter :: most_columns = 100

contains

  pure function resolved_text(scene) result(text)
    !! Return all groups of a scene, one name per line, a design or sweeps last; ends with a line feed.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    type(text_builder) :: builder
    integer, allocatable :: places(:)
    integer :: i, g
    do i = 1, size(group_table)
      places = positions_of(scene%groups, group_table(i)%name)
      do g = 1, size(places)
        call put_group(builder, scene%groups(places(g)))
      end do
    end do
    if (allocated(scene%design)) then
      call builder%append_line('&design')
      call builder%append_line('  file = '//quoted(scene%design%file))
      call builder%append_line('/')
    end if
    do i = 1, size(scene%sweeps)
      if (.not. (scene%sweeps(i)%implied .or. scene%sweeps(i)%designed)) call put_sweep(builder, scene%sweeps(i))
    end do
    text = builder%text()
  end function resolved_text

  pure function given_names(scene) result(names)
    !! Return the names that the scene gives, without defaults, as `group%name`, each once, separated by blanks.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: names
    integer :: i, g
    names = ''
    do i = 1, size(name_table)
      do g = 1, size(scene%groups)
        if (scene%groups(g)%group /= name_table(i)%group) cycle
        if (.not. scene%groups(g)%given(name_table(i)%name)) cycle
        names = names//trim(name_table(i)%group)//'%'//trim(name_table(i)%name)//' '
        exit
      end do
    end do
    names = trim(names)
  end function given_names

  pure subroutine put_group(builder, group)
    !! Write one group. A swept number is written with its sweep only, unless it is in a list.
    type(text_builder), intent(inout) :: builder
    type(group_values), intent(in) :: group
    integer :: v
    call builder%append_line('&'//trim(group%group))
    do v = 1, size(group%values)
      associate (value => group%values(v))
        if (.not. value%known .or. value%redundant) cycle
        if (value%follows_sweep() .and. group%count_of(value%name) == 1) cycle
        call put_value(builder, name_table(value%row), value)
      end associate
    end do
    call builder%append_line('/')
  end subroutine put_group

  pure subroutine put_value(builder, row, value)
    !! Write one line `name = value`.
    type(text_builder), intent(inout) :: builder
    type(input_name), intent(in) :: row
    type(input_value), intent(in) :: value
    character(:), allocatable :: start
    start = '  '//trim(row%name)//' = '
    select case (row%kind)
    case (logical_input)
      call builder%append_line(start//trim(merge('.true. ', '.false.', value%flag)))
    case (text_input)
      call builder%append_line(start//quoted(value%text))
    case (reals_input)
      call put_list(builder, start, value%numbers)
    case (texts_input, columns_input)
      call put_texts(builder, start, value)
    case (integer_input)
      call builder%append_line(start//text_of(nint(value%numbers(1), i8)))
    case default
      call builder%append_line(start//text_of(value%numbers(1)))
    end select
  end subroutine put_value

  pure subroutine put_sweep(builder, sweep)
    !! Write a sweep as it was given: evenly spaced values by their ends.
    type(text_builder), intent(inout) :: builder
    type(sweep_par), intent(in) :: sweep
    call builder%append_line('&sweep')
    call builder%append_line('  parameter = '//quoted(sweep%parameter))
    associate (values => sweep%values)
      if (sweep%spacing == '') then
        call put_list(builder, '  values = ', values)
      else
        call builder%append_line('  first = '//text_of(values(1)))
        call builder%append_line('  last = '//text_of(values(size(values))))
        call builder%append_line('  count = '//text_of(size(values)))
        call builder%append_line('  spacing = '//quoted(sweep%spacing))
      end if
    end associate
    call builder%append_line('/')
  end subroutine put_sweep

  pure subroutine put_list(builder, start, numbers)
    !! Write numbers separated by commas, over as many lines as needed.
    type(text_builder), intent(inout) :: builder
    character(*), intent(in) :: start
    real(dp), intent(in) :: numbers(:)
    character(:), allocatable :: piece
    integer :: i, column
    call builder%append(start)
    column = len(start)
    do i = 1, size(numbers)
      piece = text_of(numbers(i))
      if (i < size(numbers)) piece = piece//','
      if (column + len(piece) + 1 > most_columns) then
        call builder%append_line('')
        call builder%append('   ')
        column = 3
      end if
      if (i > 1) piece = ' '//piece
      call builder%append(piece)
      column = column + len(piece)
    end do
    call builder%append_line('')
  end subroutine put_list

  pure subroutine put_texts(builder, start, value)
    !! Write texts separated by commas, one per line; a column without a name by its number.
    type(text_builder), intent(inout) :: builder
    character(*), intent(in) :: start
    type(input_value), intent(in) :: value
    character(:), allocatable :: piece
    integer :: i
    do i = 1, size(value%texts)
      piece = '    '
      if (i == 1) piece = start
      if (value%texts(i)%text == '') piece = piece//text_of(nint(value%numbers(i), i8))
      if (value%texts(i)%text /= '') piece = piece//quoted(value%texts(i)%text)
      if (i < size(value%texts)) piece = piece//','
      call builder%append_line(piece)
    end do
  end subroutine put_texts

  pure function quoted(text) result(piece)
    !! Return a text in single quotes, with inner quotes doubled.
    character(*), intent(in) :: text
    character(:), allocatable :: piece
    piece = "'"//replaced(text, "'", "''")//"'"
  end function quoted

  pure function numeric_inputs(scene) result(inputs)
    !! Return every input of the resolved scene that is a number or a list along a dimension, in the order of the table.
    type(scene_type), intent(in) :: scene
    type(numeric_input), allocatable :: inputs(:)
    type(numeric_input) :: found(size(name_table))
    integer, allocatable :: places(:)
    integer :: i, n
    n = 0
    do i = 1, size(name_table)
      if (.not. (is_number(name_table(i)) .or. name_table(i)%along /= '')) cycle
      places = positions_of(scene%groups, name_table(i)%group)
      if (size(places) == 0) cycle
      if (.not. is_said(scene%groups(places(1)), name_table(i)%name) .and. size(places) == 1) cycle
      found(n + 1) = input_of(scene, places, name_table(i))
      if (.not. all(is_missing(found(n + 1)%values))) n = n + 1
    end do
    inputs = found(:n)
  end function numeric_inputs

  pure logical function is_said(group, name)
    !! Return whether the resolved scene has a value for the name.
    type(group_values), intent(in) :: group
    character(*), intent(in) :: name
    associate (value => group%values(group%at(name)))
      is_said = value%known .and. .not. value%redundant
    end associate
  end function is_said

  pure type(numeric_input) function input_of(scene, places, row) result(input)
    !! Return the numbers of one name in all groups that may have it; all missing if none has.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: places(:)               !! places of at least one group in the scene
    type(input_name), intent(in) :: row
    integer :: i
    input = numeric_input(row%group, row%name, row%unit, row%meaning, row%kind == integer_input)
    input%dimension = group_table(scene%groups(places(1))%row)%along
    if (input%dimension == '') then                ! one group, and one number or a list
      associate (value => scene%groups(places(1))%values(scene%groups(places(1))%at(row%name)))
        input%values = value%numbers
        input%sweeps = value%sweeps
      end associate
      if (size(input%values) > 1) input%dimension = row%along
      if (input%dimension == 'piece' .and. row%name /= 'length' .and. allocated(scene%beam%outer)) input%dimension = 'station'
    else                                           ! one number in each group
      allocate (input%values(size(places)), source=missing)
      allocate (input%sweeps(size(places)), source=0)
      do i = 1, size(places)
        if (.not. is_said(scene%groups(places(i)), row%name)) cycle
        associate (value => scene%groups(places(i))%values(scene%groups(places(i))%at(row%name)))
          input%values(i) = value%numbers(1)
          input%sweeps(i) = value%sweeps(1)
        end associate
      end do
    end if
    input%is_swept = any(input%sweeps > 0)
    if (row%group == 'contact' .and. row%name == 'stiffness') input%unit = stiffness_unit(scene%groups(places(1)))
  end function input_of

  pure function stiffness_unit(contact) result(unit)
    !! Return the unit of K in F = K d^p. UDUNITS has only integer powers: if p is swept or no integer, K is the force at d = 1 m.
    type(group_values), intent(in) :: contact
    character(:), allocatable :: unit
    unit = 'N'
    associate (exponent => contact%number('exponent'))
      if (exponent == anint(exponent) .and. .not. contact%is_swept('exponent')) unit = 'N m-'//text_of(nint(exponent))
    end associate
  end function stiffness_unit

  pure function values_of_sweep(scene, input, i) result(values)
    !! Return the values of one number of an input along its sweep: those of the sweep, or derived from them.
    type(scene_type), intent(in) :: scene
    type(numeric_input), intent(in) :: input
    integer, intent(in) :: i                       !! index of the number
    real(dp), allocatable :: values(:)
    associate (sweep => scene%sweeps(input%sweeps(i)))
      values = sweep%values
      if (input%name == 'shear_coefficient' .and. sweep%parameter == 'shear%poisson_ratio') &
        values = usual_coefficient(values, scene%beam%round)
    end associate
  end function values_of_sweep

end module bw_scene_resolved
