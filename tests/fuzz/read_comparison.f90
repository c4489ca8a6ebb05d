module read_comparison
  !! One group as the scene holds it beside what another reader took from the same text, name by name.
  use bw_input_values, only: group_values, input_value
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: same_reals

  real(dp), parameter, public :: unset = -7.25e-250_dp        !! what stands where nothing was read
  integer, parameter, public :: unset_whole = -huge(1)
  integer, parameter, public :: longest_text = 1000, most_values = 2000, most_texts = 20
  character(longest_text), parameter, public :: unset_text = achar(1)

  type, public :: comparison
    type(group_values), allocatable :: group     !! unallocated where the scene has no such group
    integer :: stat = 0                          !! how the other reading ended; 0 for well
    character(:), allocatable :: differing       !! a name that is read differently; empty for none
  contains
    procedure :: same_real
    procedure :: same_whole
    procedure :: same_text
    procedure :: same_texts
    procedure :: same_list
    procedure :: same_flag
    procedure, private :: held
  end type comparison

contains

  function held(self, name) result(value)
    !! What the scene says; not given where the group is absent.
    class(comparison), intent(in) :: self
    character(*), intent(in) :: name
    type(input_value) :: value
    if (allocated(self%group)) value = self%group%values(self%group%at(name))
  end function held

  subroutine same_real(self, name, read)
    class(comparison), intent(inout) :: self
    character(*), intent(in) :: name
    real(dp), intent(in) :: read
    type(input_value) :: value
    value = self%held(name)
    if (value%follows_sweep()) return            ! what the sweep replaced is not kept
    if (value%given .neqv. read /= unset) self%differing = name
    if (.not. value%given) return
    if (value%numbers(1) /= read) self%differing = name
  end subroutine same_real

  subroutine same_whole(self, name, read)
    class(comparison), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: read
    call self%same_real(name, merge(unset, real(read, dp), read == unset_whole))
  end subroutine same_whole

  subroutine same_text(self, name, read)
    class(comparison), intent(inout) :: self
    character(*), intent(in) :: name, read
    type(input_value) :: value
    value = self%held(name)
    if (value%given .neqv. read /= unset_text) self%differing = name
    if (.not. value%given) return
    if (value%text(:min(len(value%text), longest_text)) /= read) self%differing = name
  end subroutine same_text

  subroutine same_texts(self, name, read)
    !! A list of texts, in which holes are closed as in one of numbers.
    class(comparison), intent(inout) :: self
    character(*), intent(in) :: name, read(:)
    type(input_value) :: value
    character(len(read)), allocatable :: texts(:)
    integer :: i
    value = self%held(name)
    texts = pack(read, read /= unset_text)
    if (value%given .neqv. size(texts) > 0) self%differing = name
    if (.not. value%given) return
    if (size(value%texts) /= size(texts)) then
      self%differing = name
      return
    end if
    do i = 1, size(texts)
      if (value%texts(i)%text(:min(len(value%texts(i)%text), longest_text)) /= texts(i)) self%differing = name
    end do
  end subroutine same_texts

  subroutine same_list(self, name, read)
    !! The compiler's library takes a comment behind a comma for a value left out; ours does not, so holes are closed.
    class(comparison), intent(inout) :: self
    character(*), intent(in) :: name
    real(dp), intent(in) :: read(:)
    type(input_value) :: value
    value = self%held(name)
    if (value%follows_sweep()) return
    if (value%given) then
      if (.not. same_reals(value%numbers, closed(read))) self%differing = name
    else if (any(read /= unset)) then
      self%differing = name
    end if
  end subroutine same_list

  pure function closed(read) result(values)
    !! Without holes; what was not read stands at the end.
    real(dp), intent(in) :: read(:)
    real(dp) :: values(size(read))
    values = unset
    values(:count(read /= unset)) = pack(read, read /= unset)
  end function closed

  subroutine same_flag(self, name, read)
    class(comparison), intent(inout) :: self
    character(*), intent(in) :: name
    logical, intent(in) :: read                  !! the default where nothing was read
    type(input_value) :: value
    value = self%held(name)
    if (value%flag .neqv. read) self%differing = name
  end subroutine same_flag

  pure logical function same_reals(held, read)
    real(dp), intent(in) :: held(:)
    real(dp), intent(in) :: read(:)              !! unset behind the last value
    same_reals = .false.
    if (count(read /= unset) == size(held)) same_reals = all(held == read(:size(held)))
  end function same_reals

end module read_comparison
