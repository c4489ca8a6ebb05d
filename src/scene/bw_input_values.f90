module bw_input_values
  !! The values of the groups of a scene, by name: between the text of the scene and its types.
  use bw_kinds, only: dp
  use bw_input_name, only: name_length
  use bw_text, only: shortest, string
  implicit none (type, external)
  private
  public :: position_of, positions_of

  type, public :: input_value
    !! The value of one name in a scene.
    character(name_length) :: name = ''
    integer :: row = 0                         !! its place in `name_table`
    integer :: line = 0                        !! where it is given; 0: nowhere
    logical :: given = .false.                 !! named in its group, or swept
    logical :: known = .false.                 !! has a value: given, by default, or derived from others
    logical :: redundant = .false.             !! it repeats another value, and is not shown
    logical :: flag = .false.
    character(:), allocatable :: text
    type(string), allocatable :: texts(:)      !! texts of a list, or names of columns ('' for a column given by number), (n)
    real(dp), allocatable :: numbers(:)        !! one number or several, real or whole; unallocated: not known, (n)
    integer, allocatable :: lines(:)           !! line of each of `numbers`, (n)
    integer, allocatable :: sweeps(:)          !! index of the sweep that each number follows; 0: none, (n)
  contains
    procedure :: set_numbers
    procedure :: follow
    procedure :: follows_sweep
  end type input_value

  type, public :: group_values
    !! The values of one group of a scene, one for each of its rows in the table of names.
    character(name_length) :: group = ''
    integer :: row = 0                         !! its place in `group_table`
    integer :: line = 0                        !! where the group opens; 0 if it is only implied
    logical :: changed = .true.                !! a value has changed since the scene was last built
    type(input_value), allocatable :: values(:)
  contains
    procedure :: at
    procedure :: given
    procedure :: known
    procedure :: number
    procedure :: number_at
    procedure :: count_of
    procedure :: whole
    procedure :: text
    procedure :: line_of
    procedure :: is_swept
    procedure :: number_or_swept
    procedure :: derive
    procedure :: drop
  end type group_values

contains

  pure subroutine set_numbers(self, numbers, line)
    !! Set the numbers of a value; no sweep varies them.
    class(input_value), intent(inout) :: self
    real(dp), intent(in) :: numbers(:)
    integer, intent(in) :: line                !! of all of them
    integer :: i
    self%numbers = numbers
    self%lines = [(line, i=1, size(numbers))]
    self%sweeps = [(0, i=1, size(numbers))]
  end subroutine set_numbers

  pure subroutine follow(self, element, sweep, line, numbers, is_known)
    !! Let a sweep vary one of the numbers, which takes the sweep's first value.
    class(input_value), intent(inout) :: self
    integer, intent(in) :: element             !! index of the number
    integer, intent(in) :: sweep               !! index of the sweep
    integer, intent(in) :: line                !! line of the scene that names the sweep
    real(dp), intent(in) :: numbers(:)         !! values of the sweep, (n); of size 0 if not known
    logical, intent(in) :: is_known            !! the values are valid
    if (.not. allocated(self%numbers)) call self%set_numbers([0.0_dp], line)
    self%known = (self%known .or. size(self%numbers) == 1) .and. is_known
    self%given = .true.
    self%sweeps(element) = sweep
    self%lines(element) = line
    if (size(self%numbers) == 1) self%line = line
    if (size(numbers) > 0) self%numbers(element) = numbers(1)
  end subroutine follow

  elemental logical function follows_sweep(self)
    !! Return whether a number follows a sweep, directly or as a derived value.
    class(input_value), intent(in) :: self
    follows_sweep = .false.
    if (allocated(self%sweeps)) follows_sweep = any(self%sweeps > 0)
  end function follows_sweep

  pure integer function position_of(groups, group)
    !! Return the place of a group in a scene, the last if there are several; 0 if it is absent.
    type(group_values), intent(in) :: groups(:)
    character(*), intent(in) :: group
    do position_of = size(groups), 1, -1
      if (groups(position_of)%group == group) return
    end do
  end function position_of

  pure function positions_of(groups, group) result(positions)
    !! Return the places of all groups of this name, in the order of the scene.
    type(group_values), intent(in) :: groups(:)
    character(*), intent(in) :: group
    integer, allocatable :: positions(:)
    integer :: g
    positions = pack([(g, g=1, size(groups))], groups%group == group)
  end function positions_of

  pure integer function at(self, name)
    !! Return the place of a name in its group; 0 if the group has no such name.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    do at = size(self%values), 1, -1
      if (self%values(at)%name == name) return
    end do
  end function at

  pure logical function given(self, name)
    !! Return whether the name is given in its group, or a sweep varies it.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    given = self%values(self%at(name))%given
  end function given

  pure logical function known(self, name)
    !! Return whether the name has a value.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    known = self%values(self%at(name))%known
  end function known

  pure real(dp) function number(self, name)
    !! Return a real or a whole number, the first of a list; 0 if it is not known.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    number = self%number_at(name, 1)
  end function number

  pure real(dp) function number_at(self, name, i) result(number)
    !! Return number i of a list; a single number applies to all i. 0 if it is not known.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: i
    number = 0.0_dp
    associate (value => self%values(self%at(name)))
      if (allocated(value%numbers)) number = value%numbers(min(i, size(value%numbers)))
    end associate
  end function number_at

  pure integer function count_of(self, name) result(count)
    !! Count the numbers of a name; 0 if none is known.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    count = 0
    associate (value => self%values(self%at(name)))
      if (allocated(value%numbers)) count = size(value%numbers)
    end associate
  end function count_of

  pure integer function whole(self, name)
    !! Return a whole number; its range in the table lies within that of integers.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    whole = nint(self%number(name))
  end function whole

  pure function text(self, name)
    !! Return the value of a text.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    character(:), allocatable :: text
    text = self%values(self%at(name))%text
  end function text

  pure integer function line_of(self, name)
    !! Return the line of the scene at which the name is given; 0 if it is not given.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    line_of = self%values(self%at(name))%line
  end function line_of

  pure logical function is_swept(self, name)
    !! Return whether a value of the name follows a sweep, directly or as a derived value.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    is_swept = self%values(self%at(name))%follows_sweep()
  end function is_swept

  pure function number_or_swept(self, name, unit, digits) result(text)
    !! Return a number as reports show it, or the word `swept`.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: unit           !! with a leading blank
    integer, intent(in), optional :: digits    !! significant digits; absent: six
    character(:), allocatable :: text
    integer :: most
    most = 6
    if (present(digits)) most = digits
    text = shortest(self%number(name), most)//unit
    if (self%is_swept(name)) text = 'swept'
  end function number_or_swept

  pure subroutine derive(self, name, number, sweep)
    !! Set a derived number; `sweep` is the sweep that it follows.
    class(group_values), intent(inout) :: self
    character(*), intent(in) :: name
    real(dp), intent(in) :: number
    integer, intent(in) :: sweep
    associate (value => self%values(self%at(name)))
      call value%set_numbers([number], 0)
      value%sweeps = sweep
      value%known = .true.
    end associate
  end subroutine derive

  pure subroutine drop(self, name)
    !! Mark a value that only repeats another as redundant, so that it is not shown.
    class(group_values), intent(inout) :: self
    character(*), intent(in) :: name
    self%values(self%at(name))%redundant = .true.
  end subroutine drop

end module bw_input_values
