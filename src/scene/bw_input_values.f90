module bw_input_values
  !! What the groups of a scene say, value by value: between the text of the scene and its types.
  use bw_kinds, only: dp
  use bw_input_name, only: name_length
  use bw_text, only: shortest, string
  implicit none (type, external)
  private
  public :: position_of, positions_of

  type, public :: input_value
    !! What a scene says about one name.
    character(name_length) :: name = ''
    integer :: row = 0                         !! its place in `name_table`
    integer :: line = 0                        !! where it is said; 0: nowhere
    logical :: given = .false.                 !! named in its group, or swept
    logical :: known = .false.                 !! has a value: given, by default, or derived from others
    logical :: redundant = .false.             !! only repeats another value, and is not shown beside it
    logical :: flag = .false.
    character(:), allocatable :: text
    type(string), allocatable :: texts(:)      !! of a list of texts, or names of columns, '' where a number stands for it, (n)
    real(dp), allocatable :: numbers(:)        !! of one number or several, whole or not; unallocated where none is known, (n)
    integer, allocatable :: lines(:)           !! line of each of `numbers`, (n)
    integer, allocatable :: sweeps(:)          !! number of the sweep that each of them follows; 0: none, (n)
  contains
    procedure :: set_numbers
    procedure :: follow
    procedure :: follows_sweep
  end type input_value

  type, public :: group_values
    !! What a scene says in one group: a value for each row of the group in the table of names.
    character(name_length) :: group = ''
    integer :: row = 0                         !! its place in `group_table`
    integer :: line = 0                        !! where the group opens; 0 where it is only implied
    logical :: changed = .true.                !! values are others than those that the scene was built from last
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
    !! Give a value its numbers, which no sweep varies.
    class(input_value), intent(inout) :: self
    real(dp), intent(in) :: numbers(:)
    integer, intent(in) :: line                !! of all of them
    integer :: i
    self%numbers = numbers
    self%lines = [(line, i=1, size(numbers))]
    self%sweeps = [(0, i=1, size(numbers))]
  end subroutine set_numbers

  pure subroutine follow(self, element, sweep, line, numbers, is_known)
    !! Let a sweep give one of the numbers, whose value is that of the first case from here on.
    class(input_value), intent(inout) :: self
    integer, intent(in) :: element             !! which of the numbers
    integer, intent(in) :: sweep               !! its number
    integer, intent(in) :: line                !! of the scene, which says so
    real(dp), intent(in) :: numbers(:)         !! of the sweep, (n); of size 0 where they are not known
    logical, intent(in) :: is_known            !! they are right
    if (.not. allocated(self%numbers)) call self%set_numbers([0.0_dp], line)
    self%known = (self%known .or. size(self%numbers) == 1) .and. is_known
    self%given = .true.
    self%sweeps(element) = sweep
    self%lines(element) = line
    if (size(self%numbers) == 1) self%line = line
    if (size(numbers) > 0) self%numbers(element) = numbers(1)
  end subroutine follow

  elemental logical function follows_sweep(self)
    !! A sweep gives one of its numbers, or what that follows from.
    class(input_value), intent(in) :: self
    follows_sweep = .false.
    if (allocated(self%sweeps)) follows_sweep = any(self%sweeps > 0)
  end function follows_sweep

  pure integer function position_of(groups, group)
    !! Place of a group among those of a scene, the last one of those that it may have several of; 0 where it is absent.
    type(group_values), intent(in) :: groups(:)
    character(*), intent(in) :: group
    do position_of = size(groups), 1, -1
      if (groups(position_of)%group == group) return
    end do
  end function position_of

  pure function positions_of(groups, group) result(positions)
    !! Places of all groups of that name among those of a scene, in the order of the scene.
    type(group_values), intent(in) :: groups(:)
    character(*), intent(in) :: group
    integer, allocatable :: positions(:)
    integer :: g
    positions = pack([(g, g=1, size(groups))], groups%group == group)
  end function positions_of

  pure integer function at(self, name)
    !! Place of a name in its group; 0 where the group has no such name.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    do at = size(self%values), 1, -1
      if (self%values(at)%name == name) return
    end do
  end function at

  pure logical function given(self, name)
    !! The name stands in its group, or a sweep varies it.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    given = self%values(self%at(name))%given
  end function given

  pure logical function known(self, name)
    !! The name has a value.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    known = self%values(self%at(name))%known
  end function known

  pure real(dp) function number(self, name)
    !! The value of a real or a whole number, of a list the first; 0 where none is known.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    number = self%number_at(name, 1)
  end function number

  pure real(dp) function number_at(self, name, i) result(number)
    !! Number i of a list; one number alone stands for all. 0 where none is known.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: i
    number = 0.0_dp
    associate (value => self%values(self%at(name)))
      if (allocated(value%numbers)) number = value%numbers(min(i, size(value%numbers)))
    end associate
  end function number_at

  pure integer function count_of(self, name) result(count)
    !! How many numbers a name has; 0 where none is known.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    count = 0
    associate (value => self%values(self%at(name)))
      if (allocated(value%numbers)) count = size(value%numbers)
    end associate
  end function count_of

  pure integer function whole(self, name)
    !! A whole number; the table keeps its range within that of integers.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    whole = nint(self%number(name))
  end function whole

  pure function text(self, name)
    !! The value of a text.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    character(:), allocatable :: text
    text = self%values(self%at(name))%text
  end function text

  pure integer function line_of(self, name)
    !! Line of the scene at which the name is given; 0 where it is not.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    line_of = self%values(self%at(name))%line
  end function line_of

  pure logical function is_swept(self, name)
    !! A sweep gives its values, or those that it follows from.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    is_swept = self%values(self%at(name))%follows_sweep()
  end function is_swept

  pure function number_or_swept(self, name, unit, digits) result(text)
    !! A number as reports show it, or the word `swept`.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: unit           !! with the blank before it
    integer, intent(in), optional :: digits    !! of the number; else six
    character(:), allocatable :: text
    integer :: most
    most = 6
    if (present(digits)) most = digits
    text = shortest(self%number(name), most)//unit
    if (self%is_swept(name)) text = 'swept'
  end function number_or_swept

  pure subroutine derive(self, name, number, sweep)
    !! Give a number that follows from others; `sweep` is the sweep that it then follows.
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
    !! Let a value that only repeats another go unsaid.
    class(group_values), intent(inout) :: self
    character(*), intent(in) :: name
    self%values(self%at(name))%redundant = .true.
  end subroutine drop

end module bw_input_values
