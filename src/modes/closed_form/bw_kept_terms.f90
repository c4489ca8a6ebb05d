module bw_kept_terms
  !! Far modes that estimates of errors look at, which cases share: their roots and shapes have nothing to do with how fast
  !! the beam turns. Cases with the same mass and points find them once, the oldest list making room for the newest. What
  !! is kept is what would be found again, to the bit.
  use bw_double_double, only: dd, to_dd
  use bw_far_terms, only: far_frequencies, far_shapes_and_roots
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private

  integer, parameter :: most_lists = 64           !! kept at a time
  integer, parameter :: most_numbers = 4096       !! of one that is kept: all together take less than 4 MB

  type :: kept_list
    real(dp) :: gamma = 0.0_dp
    logical :: light = .false.
    integer, allocatable :: k(:)
    real(dp), allocatable :: xi(:), rest(:), drive(:), shapes(:, :)
    type(dd), allocatable :: alpha(:)
  end type kept_list

  type, public :: kept_terms
    private
    type(kept_list), allocatable :: lists(:)
    integer, public :: found = 0                  !! lists that were ever kept
    integer :: last = 0                           !! the place of the one that was asked for last
  contains
    procedure, nopass :: takes
    procedure :: terms
    procedure, private :: find
  end type kept_terms

contains

  pure logical function takes(k, xi)
    !! The list is not too long.
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: xi(:)
    takes = int(size(k), i8)*(size(xi) + 5) <= most_numbers
  end function takes

  pure subroutine terms(self, k, gamma, light, omega, xi, beta, drive, shapes)
    !! `far_terms` of a list that `takes`, for no longest time.
    class(kept_terms), intent(inout) :: self
    integer, intent(in) :: k(:)                   !! as those of `far_terms`
    real(dp), intent(in) :: gamma
    logical, intent(in) :: light
    type(dd), intent(in), optional :: omega
    real(dp), intent(in) :: xi(:)
    type(dd), intent(out) :: beta(:)
    real(dp), intent(out) :: drive(:), shapes(:, :)
    integer :: place
    call self%find(k, gamma, light, xi, place)
    associate (list => self%lists(place))
      call far_frequencies(k, to_dd(gamma), light, omega, rest=list%rest, roots=list%alpha, beta=beta)
      drive = list%drive
      shapes = list%shapes
    end associate
  end subroutine terms

  pure subroutine find(self, k, gamma, light, xi, place)
    !! Where in `lists` the modes are; they are solved if they are not there.
    class(kept_terms), intent(inout) :: self
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: gamma, xi(:)
    logical, intent(in) :: light
    integer, intent(out) :: place
    integer :: held, i
    if (.not. allocated(self%lists)) allocate (self%lists(most_lists))
    held = min(self%found, most_lists)
    do i = 0, held - 1
      place = 1 + mod(self%last + i, held)        ! cases ask for one list after the other, all in the same order
      self%last = place
      if (holds(self%lists(place), k, gamma, light, xi)) return
    end do
    place = 1 + mod(self%found, most_lists)
    self%last = place
    self%found = self%found + 1
    self%lists(place) = kept_list(gamma, light, k, xi)
    associate (list => self%lists(place))
      allocate (list%rest(size(k)), list%drive(size(k)), list%shapes(size(k), size(xi)), list%alpha(size(k)))
      call far_shapes_and_roots(k, gamma, light, xi, list%rest, list%alpha, list%drive, list%shapes)
    end associate
  end subroutine find

  pure logical function holds(list, k, gamma, light, xi)
    type(kept_list), intent(in) :: list
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: gamma, xi(:)
    logical, intent(in) :: light
    holds = list%gamma == gamma .and. (list%light .eqv. light) .and. size(list%k) == size(k) .and. size(list%xi) == size(xi)
    if (holds) holds = all(list%k == k)
    if (holds) holds = all(list%xi == xi)
  end function holds

end module bw_kept_terms
