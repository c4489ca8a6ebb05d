module bw_mode_cache
  !! What modes in closed form have in common however fast the beam turns and however long it is watched: roots, shapes and
  !! masses. Cases that share a cache find them once, each set when it is first asked for. What is in the cache is what would
  !! be found again, to the bit.
  use bw_kinds, only: dp, i8
  use bw_double_double, only: dd
  use bw_far_modes, only: far_beam, far_frequencies, far_shapes_and_roots
  use bw_refined_root, only: is_coarse, refine_roots
  use bw_root_list, only: batch, root_values, solve_roots
  use bw_shape, only: shape_type, shapes_of
  implicit none (type, external)
  private

  integer, parameter :: most_sets = 128          !! cached at a time
  integer, parameter :: most_modes = 1024        !! of a set that is cached: all together take less than 20 MB
  integer, parameter :: most_lists = 64          !! of far modes, cached at a time
  integer, parameter :: most_numbers = 4096      !! of one that is cached: all together take less than 4 MB

  type, public :: cached_set
    !! The first n modes of one mass ratio.
    integer :: key = 0                           !! no other set that was ever cached has the same
    type(dd) :: gamma
    type(shape_type), allocatable :: shape(:)    !! (n)
    type(dd), allocatable :: alpha(:)            !! roots as binary64 carries them, (n)
    type(dd), allocatable, private :: refined(:) !! the same, in extended precision where a case has asked for it
    logical, allocatable, private :: is_refined(:)
  contains
    procedure :: roots => roots_for_case
  end type cached_set

  type :: far_list
    !! Far modes of one mass ratio, and their shapes at points.
    real(dp) :: gamma = 0.0_dp
    integer, allocatable :: k(:)
    real(dp), allocatable :: xi(:), remainder(:), drive(:), shapes(:, :)
    type(dd), allocatable :: alpha(:)
  end type far_list

  type, public :: mode_cache
    !! Sets, and lists of the far modes that estimates of errors look at, in the order in which they came; the newest replaces
    !! the oldest.
    type(cached_set), allocatable :: sets(:)
    integer, private :: found = 0                !! sets that were ever cached
    type(far_list), allocatable, private :: lists(:)
    integer :: found_lists = 0                   !! lists that were ever cached
    integer, private :: last_list = 0            !! the place of the one that was asked for last
  contains
    procedure, nopass :: has_room_for_set
    procedure :: find_set
    procedure, nopass :: has_room_for_list
    procedure :: far_terms => cached_far_terms
    procedure, private :: find_list
  end type mode_cache

contains

  pure logical function has_room_for_set(number)
    !! Whether these modes are the first ones, and few enough to be cached.
    integer, intent(in) :: number(:)             !! ascending
    has_room_for_set = .false.
    if (size(number) == 0 .or. size(number) > most_modes) return
    has_room_for_set = number(size(number)) == size(number)
  end function has_room_for_set

  subroutine find_set(self, count, gamma, place)
    !! Find the place in `sets` of the first `count` modes, which are solved if they are not there.
    class(mode_cache), intent(inout) :: self
    integer, intent(in) :: count                 !! one that the cache has room for
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
    self%sets(place)%key = self%found
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
    !! Find α as one case needs it: what `is_coarse` there is solved again in extended precision, once for all cases.
    class(cached_set), intent(inout) :: self
    type(dd), intent(in), optional :: omega      !! as those of `is_coarse`
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

  ! Far modes

  pure logical function has_room_for_list(k, xi)
    !! Whether these far modes are few enough to be cached.
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: xi(:)
    has_room_for_list = int(size(k), i8)*(size(xi) + 5) <= most_numbers
  end function has_room_for_list

  pure subroutine cached_far_terms(self, k, beam, xi, beta, drive, shapes)
    !! Find the `far_terms` of bw_far_modes, of a list that the cache has room for.
    class(mode_cache), intent(inout) :: self
    integer, intent(in) :: k(:)                  !! as those of `far_terms`
    type(far_beam), intent(in) :: beam
    real(dp), intent(in) :: xi(:)
    type(dd), intent(out) :: beta(:)
    real(dp), intent(out) :: drive(:), shapes(:, :)
    integer :: place
    call self%find_list(k, beam%gamma%hi, xi, place)
    associate (list => self%lists(place))
      call far_frequencies(k, beam, list%remainder, list%alpha, beta)
      drive = list%drive
      shapes = list%shapes
    end associate
  end subroutine cached_far_terms

  pure subroutine find_list(self, k, gamma, xi, place)
    !! Find the place in `lists` of far modes, which are solved if they are not there.
    class(mode_cache), intent(inout) :: self
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: gamma, xi(:)
    integer, intent(out) :: place
    integer :: cached, i
    if (.not. allocated(self%lists)) allocate (self%lists(most_lists))
    cached = min(self%found_lists, most_lists)
    do i = 0, cached - 1
      place = 1 + mod(self%last_list + i, cached)      ! cases ask for one list after the other, all in the same order
      self%last_list = place
      if (is_same_list(self%lists(place), k, gamma, xi)) return
    end do
    place = 1 + mod(self%found_lists, most_lists)
    self%last_list = place
    self%found_lists = self%found_lists + 1
    self%lists(place) = far_list(gamma, k, xi)
    associate (list => self%lists(place))
      allocate (list%remainder(size(k)), list%drive(size(k)), list%shapes(size(k), size(xi)), list%alpha(size(k)))
      call far_shapes_and_roots(k, gamma, xi, list%remainder, list%alpha, list%drive, list%shapes)
    end associate
  end subroutine find_list

  pure logical function is_same_list(list, k, gamma, xi) result(same)
    !! Whether a list is of these modes, this mass ratio and these points.
    type(far_list), intent(in) :: list
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: gamma, xi(:)
    same = list%gamma == gamma .and. size(list%k) == size(k) .and. size(list%xi) == size(xi)
    if (same) same = all(list%k == k)
    if (same) same = all(list%xi == xi)
  end function is_same_list

end module bw_mode_cache
