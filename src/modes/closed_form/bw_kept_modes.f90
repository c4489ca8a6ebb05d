module bw_kept_modes
  !! What modes in closed form have in common however fast the beam turns and however long it is watched: roots, shapes and
  !! masses. Cases that share them find them once: each set is solved when it is first asked for, and kept as long as there
  !! is room. What is kept is what would be found again, to the bit.
  use bw_kinds, only: dp, i8
  use bw_double_double, only: dd
  use bw_kept_terms, only: kept_terms
  use bw_refined_root, only: is_coarse, refine_roots
  use bw_root_list, only: root_values, solve_roots
  use bw_shape, only: shape_type, shape_values, shapes_of
  implicit none (type, external)
  private

  integer, parameter, public :: chunk = 256      !! tuned: modes whose arrays stay in the fastest cache
  integer, parameter :: most_sets = 128          !! kept at a time
  integer, parameter :: most_modes = 1024        !! of a set that is kept: all together take less than 20 MB
  integer, parameter :: most_values = 4096       !! of the shapes of a set that are kept: all together take 4 MB

  type, public :: kept_set
    !! The first n modes of one mass ratio.
    integer :: number = 0                        !! no other set that was kept has the same
    type(dd) :: gamma
    type(shape_type), allocatable :: shape(:)    !! (n)
    type(dd), allocatable :: alpha(:)            !! roots as binary64 carries them, (n)
    type(dd), allocatable, private :: refined(:) !! the same, in extended precision where a case has asked for it
    logical, allocatable, private :: is_refined(:)
    real(dp), allocatable, private :: xi(:), values(:, :)   !! where shapes were asked for last, and what they are there
  contains
    procedure :: roots => roots_for_case
    procedure :: shapes_at
  end type kept_set

  type, public :: kept_modes
    !! Sets in the order in which they came; the oldest makes room for the newest.
    type(kept_set), allocatable :: sets(:)
    type(kept_terms) :: terms                    !! far modes that estimates of errors look at
    integer, private :: found = 0                !! sets that were ever kept
  contains
    procedure, nopass :: takes
    procedure :: place => place_of_set
  end type kept_modes

contains

  pure logical function takes(number)
    !! The list is of the first modes, and not too long.
    integer, intent(in) :: number(:)             !! ascending
    takes = .false.
    if (size(number) == 0 .or. size(number) > most_modes) return
    takes = number(size(number)) == size(number)
  end function takes

  subroutine place_of_set(self, count, gamma, place)
    !! Where in `sets` the first `count` modes are; they are solved if they are not there.
    class(kept_modes), intent(inout) :: self
    integer, intent(in) :: count                 !! one that `takes`
    type(dd), intent(in) :: gamma
    integer, intent(out) :: place
    if (.not. allocated(self%sets)) allocate (self%sets(most_sets))
    do place = 1, min(self%found, most_sets)
      associate (set => self%sets(place))
        if (set%gamma%hi == gamma%hi .and. set%gamma%lo == gamma%lo .and. size(set%shape) == count) return
      end associate
    end do
    place = 1 + mod(self%found, most_sets)
    self%found = self%found + 1
    call solve_set(count, gamma, self%sets(place))
    self%sets(place)%number = self%found
  end subroutine place_of_set

  pure subroutine solve_set(count, gamma, set)
    integer, intent(in) :: count
    type(dd), intent(in) :: gamma
    type(kept_set), intent(out) :: set
    integer :: k
    set%gamma = gamma
    allocate (set%shape(count))
    allocate (set%is_refined(count), source=.false.)
    call solve_shapes([(k, k=1, count)], gamma%hi, set%shape)
    set%shape%root%gamma_low = gamma%lo
    set%alpha = root_values(set%shape%root)
    set%refined = set%alpha
  end subroutine solve_set

  pure subroutine roots_for_case(self, omega, longest, alpha)
    !! α as one case needs it: solved again in extended precision what `is_coarse` there, once for all cases.
    class(kept_set), intent(inout) :: self
    type(dd), intent(in), optional :: omega      !! as those of `is_coarse`
    real(dp), intent(in), optional :: longest
    type(dd), intent(out) :: alpha(:)            !! (n)
    logical :: coarse(size(alpha)), new(size(alpha))
    alpha = self%alpha
    coarse = is_coarse(self%shape%root%rest, alpha%hi, omega, longest)
    if (.not. any(coarse)) return
    new = coarse .and. .not. self%is_refined
    call refine_roots(self%shape%root, new, self%refined)
    self%is_refined = self%is_refined .or. new
    where (coarse) alpha = self%refined
  end subroutine roots_for_case

  pure subroutine shapes_at(self, xi, values)
    !! Φ_k(ξ_p) at the points that the cases share; unallocated where these are too many to be kept.
    class(kept_set), intent(inout) :: self
    real(dp), intent(in) :: xi(:)                !! (points)
    real(dp), allocatable, intent(out) :: values(:, :)   !! (n, points)
    logical :: known
    integer :: p
    if (int(size(self%shape), i8)*size(xi) > most_values) return
    known = allocated(self%xi)
    if (known) known = size(self%xi) == size(xi)
    if (known) known = all(self%xi == xi)
    if (.not. known) then
      self%xi = xi
      self%values = reshape([(shape_values(self%shape, xi(p)), p=1, size(xi))], [size(self%shape), size(xi)])
    end if
    values = self%values
  end subroutine shapes_at

  pure subroutine solve_shapes(number, gamma, shape)
    !! Shapes of modes of any numbers, in their order.
    integer, intent(in) :: number(:)             !! k ≥ 1, ascending
    real(dp), intent(in) :: gamma
    type(shape_type), intent(out) :: shape(:)
    integer :: first, last
    do first = 1, size(number), chunk
      last = min(first + chunk - 1, size(number))
      shape(first:last) = shapes_of(solve_roots(number(first:last), gamma))
    end do
  end subroutine solve_shapes

end module bw_kept_modes
