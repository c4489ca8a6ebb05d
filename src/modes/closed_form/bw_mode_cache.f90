module bw_mode_cache
  !! Data of modes in closed form that do not depend on rotation or duration: roots, shapes and masses. Cases that share
  !! a cache compute each set once. Cached data equal recomputed ones to the bit.
  use bw_kinds, only: dp, i8
  use bw_double_double, only: dd
  use bw_mode_set, only: batch
  use bw_refined_root, only: is_coarse, refine_roots
  use bw_root_list, only: root_values, solve_roots
  use bw_shape, only: shape_type, shapes_of
  implicit none (type, external)
  private

  integer, parameter :: most_sets = 128          !! most sets in the cache
  integer, parameter :: most_modes = 1024        !! most modes of a cached set: together less than 20 MB
  integer, parameter :: most_values = 16384      !! most shape values of a set at points: together less than 20 MB

  type, public :: shape_table
    !! Shapes of some modes at some points.
    real(dp), allocatable :: xi(:), values(:, :)     !! (points), (modes, points); unallocated: none
  contains
    procedure :: is_of
    procedure, nopass :: has_room_for
  end type shape_table

  type, public :: cached_set
    !! The first n modes of one mass ratio.
    type(dd) :: gamma
    type(shape_type), allocatable :: shape(:)    !! (n)
    type(dd), allocatable :: alpha(:)            !! roots in binary64, (n)
    type(shape_table) :: at_points               !! shapes of all of them at the points requested last
    type(dd), allocatable, private :: refined(:) !! the same in extended precision, once needed
    logical, allocatable, private :: is_refined(:)
  contains
    procedure :: roots => roots_for_case
  end type cached_set

  type, public :: mode_cache
    !! Sets in the order of their entry. The newest replaces the oldest.
    type(cached_set), allocatable :: sets(:)
    integer, private :: found = 0                !! entries made so far
  contains
    procedure, nopass :: has_room_for_set
    procedure :: find_set
  end type mode_cache

contains

  pure logical function has_room_for_set(number)
    !! Return whether these are the first modes, and few enough for the cache.
    integer, intent(in) :: number(:)             !! ascending
    has_room_for_set = .false.
    if (size(number) == 0 .or. size(number) > most_modes) return
    has_room_for_set = number(size(number)) == size(number)
  end function has_room_for_set

  subroutine find_set(self, count, gamma, place)
    !! Find the index in `sets` of the first `count` modes, which are solved if missing.
    class(mode_cache), intent(inout) :: self
    integer, intent(in) :: count                 !! at most as many as the cache has room for
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
  end subroutine find_set

  pure subroutine solve_set(count, gamma, set)
    !! Find the first `count` modes.
    integer, intent(in) :: count
    type(dd), intent(in) :: gamma
    type(cached_set), intent(out) :: set
    integer :: first, k, last
    set%gamma = gamma
    allocate (set%shape(count))
    allocate (set%is_refined(count), source=.false.)
    do first = 1, count, batch
      last = min(first + batch - 1, count)
      set%shape(first:last) = shapes_of(solve_roots([(k, k=first, last)], gamma%hi))
    end do
    set%shape%root%gamma_low = gamma%lo
    set%alpha = root_values(set%shape%root)
    set%refined = set%alpha
  end subroutine solve_set

  pure subroutine roots_for_case(self, omega, longest, alpha)
    !! Find α for one case. Roots that are `is_coarse` in it are refined in extended precision, once for all cases.
    class(cached_set), intent(inout) :: self
    type(dd), intent(in), optional :: omega      !! see `is_coarse`
    real(dp), intent(in), optional :: longest
    type(dd), intent(out) :: alpha(:)            !! (n)
    logical :: coarse(size(alpha)), new(size(alpha))
    alpha = self%alpha
    coarse = is_coarse(self%shape%root%remainder, alpha%hi, omega, longest)
    if (.not. any(coarse)) return
    new = coarse .and. .not. self%is_refined
    call refine_roots(self%shape%root, new, self%refined)
    self%is_refined = self%is_refined .or. new
    where (coarse) alpha = self%refined
  end subroutine roots_for_case

  ! Shapes at points

  pure logical function is_of(self, xi)
    !! Return whether the shapes at these points are stored.
    class(shape_table), intent(in) :: self
    real(dp), intent(in) :: xi(:)
    is_of = .false.
    if (allocated(self%xi)) is_of = size(self%xi) == size(xi)
    if (is_of) is_of = all(self%xi == xi)
  end function is_of

  pure logical function has_room_for(modes, xi)
    !! Return whether so many modes have few enough shape values at these points for the cache.
    integer, intent(in) :: modes
    real(dp), intent(in) :: xi(:)
    has_room_for = int(modes, i8)*size(xi) <= most_values
  end function has_room_for

end module bw_mode_cache
