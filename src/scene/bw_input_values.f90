module bw_input_values
  !! What the groups of a scene say, value by value: between the text of the scene and its types.
  use bw_kinds, only: dp
  use bw_input_name, only: name_length
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: position_of

  type, public :: input_value
    !! What a scene says about one name.
    character(name_length) :: name = ''
    integer :: row = 0                         !! its place in `name_table`
    integer :: line = 0                        !! where it is said; 0: nowhere
    logical :: given = .false.                 !! named in its group, or swept
    logical :: known = .false.                 !! has a value: given, by default, or settled from others
    logical :: redundant = .false.             !! only repeats another value, and is not shown beside it
    integer :: sweep = 0                       !! number of the sweep that it follows; 0: none
    real(dp) :: number = 0.0_dp                !! of a real or a whole number
    logical :: flag = .false.
    character(:), allocatable :: text
    real(dp), allocatable :: numbers(:)        !! (n)
    integer, allocatable :: lines(:)           !! line of each of `numbers`, (n)
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
    procedure :: whole
    procedure :: text
    procedure :: line_of
    procedure :: is_swept
    procedure :: number_or_swept
    procedure :: settle
    procedure :: drop
  end type group_values

contains

  pure integer function position_of(groups, group)
    !! Place of a group among those of a scene; 0 where it is absent.
    type(group_values), intent(in) :: groups(:)
    character(*), intent(in) :: group
    do position_of = size(groups), 1, -1
      if (groups(position_of)%group == group) return
    end do
  end function position_of

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
    !! The value of a real or a whole number.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    number = self%values(self%at(name))%number
  end function number

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
    is_swept = self%values(self%at(name))%sweep > 0
  end function is_swept

  pure function number_or_swept(self, name, unit) result(text)
    !! A number to six digits as reports show it, or the word `swept`.
    class(group_values), intent(in) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: unit           !! with the blank before it
    character(:), allocatable :: text
    text = shortest(self%number(name), 6)//unit
    if (self%is_swept(name)) text = 'swept'
  end function number_or_swept

  pure subroutine settle(self, name, number, sweep)
    !! Give a number that follows from others; `sweep` is the sweep that it then follows.
    class(group_values), intent(inout) :: self
    character(*), intent(in) :: name
    real(dp), intent(in) :: number
    integer, intent(in) :: sweep
    associate (value => self%values(self%at(name)))
      value%number = number
      value%sweep = sweep
      value%known = .true.
    end associate
  end subroutine settle

  pure subroutine drop(self, name)
    !! Let a value that only repeats another go unsaid.
    class(group_values), intent(inout) :: self
    character(*), intent(in) :: name
    self%values(self%at(name))%redundant = .true.
  end subroutine drop

end module bw_input_values
