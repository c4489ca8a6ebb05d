module bw_closed_form
  !! The modes of a uniform clamped beam with a tip mass, rotating without tension: Eqs 7–9 and 18–21.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, operator(*), operator(+), operator(-)
  use bw_far_runs, only: far_run_terms, is_far_run
  use bw_far_terms, only: far_terms
  use bw_frequency_equation, only: highest_mode, root_type
  use bw_kept_modes, only: chunk, kept_modes, kept_set
  use bw_mode_set, only: mode_set, mode_source, terms_of_set
  use bw_overlap, only: overlap_with_tip_mass, overlap_without_mass
  use bw_refined_root, only: is_coarse, refine_roots
  use bw_root_list, only: light_modes, near_modes, root_values, solve_roots
  use bw_shape, only: shape_type, shapes_of, shape_values
  use bw_wave_velocity, only: phase_velocity, group_velocity
  implicit none (type, external)
  private
  public :: closed_form_modes, source_in_closed_form

  type, extends(mode_set), public :: closed_form_set
    type(root_type), allocatable :: root(:)        !! from which shapes follow, (n)
    real(dp), allocatable :: known_at(:)           !! points where they are known already; unallocated: none
    real(dp), allocatable :: known(:, :)           !! Φ_k there, (n, points)
  contains
    procedure :: some_shapes => closed_form_shapes
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: overlap_far_below
    procedure :: elastic => closed_form_elastic
  end type closed_form_set

  type, extends(mode_source), public :: closed_form_source
    type(dd), allocatable :: omega                 !! in-plane angular velocity in h/l²; absent: none
    type(kept_modes), pointer :: kept => null()    !! what cases share; not associated: nothing is kept
  contains
    procedure :: find => find_in_closed_form
    procedure :: terms => terms_in_closed_form
  end type closed_form_source

contains

  pure type(closed_form_set) function closed_form_modes(count, gamma, omega, longest) result(modes)
    !! The first `count` modes; γ = 0 is the beam alone.
    integer, intent(in) :: count           !! ≥ 1
    real(dp), intent(in) :: gamma          !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
    real(dp), intent(in), optional :: longest
    integer :: k
    call set_modes([(k, k=1, count)], gamma, omega, longest, modes)
  end function closed_form_modes

  pure subroutine set_modes(number, gamma, omega, longest, modes)
    !! Modes of any numbers, in their order.
    integer, intent(in) :: number(:)       !! k ≥ 1, ascending
    real(dp), intent(in) :: gamma          !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
      !! in-plane angular velocity in units of h/l²; absent: no rotation acts on the modes
    real(dp), intent(in), optional :: longest
      !! the longest time, in l²/h, after which phases must still be right; absent: no history is asked for
    type(closed_form_set), intent(out) :: modes
    type(shape_type) :: shape(chunk)
    type(dd) :: alpha(chunk)
    integer :: first, last, m
    call size_set(size(number), gamma, modes)
    do first = 1, size(number), chunk
      last = min(first + chunk - 1, size(number))
      m = last - first + 1
      shape(:m) = shapes_of(solve_roots(number(first:last), gamma))
      alpha(:m) = root_values(shape(:m)%root)
      call refine_roots(shape(:m)%root, is_coarse(shape(:m)%root%rest, alpha(:m)%hi, omega, longest), alpha(:m))
      call set_some(first, last, shape(:m), alpha(:m), omega, modes)
    end do
  end subroutine set_modes

  pure subroutine set_kept_modes(kept, points, omega, longest, modes)
    !! The same of modes whose shapes are known.
    type(kept_set), intent(inout) :: kept
    real(dp), intent(in), optional :: points(:)    !! where shapes will be asked for
    type(dd), intent(in), optional :: omega
    real(dp), intent(in), optional :: longest
    type(closed_form_set), intent(out) :: modes
    type(dd) :: alpha(size(kept%shape))
    integer :: first, last
    call size_set(size(kept%shape), kept%gamma, modes)
    modes%kept_as = kept%number
    if (present(points)) call kept%shapes_at(points, modes%known)
    if (allocated(modes%known)) modes%known_at = points
    call kept%roots(omega, longest, alpha)
    do first = 1, modes%count, chunk
      last = min(first + chunk - 1, modes%count)
      call set_some(first, last, kept%shape(first:last), alpha(first:last), omega, modes)
    end do
  end subroutine set_kept_modes

  pure subroutine size_set(n, gamma, modes)
    integer, intent(in) :: n
    real(dp), intent(in) :: gamma
    type(closed_form_set), intent(inout) :: modes
    modes%count = n
    modes%gamma = gamma
    allocate (modes%root(n), modes%alpha(n), modes%tip(n), modes%modal_mass(n), modes%beta_squared(n))
    allocate (modes%phase_velocity(n), modes%group_velocity(n))
  end subroutine size_set

  pure subroutine set_some(first, last, shape, alpha, omega, modes)
    !! Modes `first` … `last` of a set.
    integer, intent(in) :: first, last
    type(shape_type), intent(in) :: shape(:)
    type(dd), intent(in) :: alpha(:)
    type(dd), intent(in), optional :: omega
    type(closed_form_set), intent(inout) :: modes
    type(dd) :: square(last - first + 1)
    associate (beta_squared => modes%beta_squared(first:last))
      modes%root(first:last) = shape%root
      modes%alpha(first:last) = shape%alpha
      modes%tip(first:last) = shape%tip
      modes%modal_mass(first:last) = shape%modal_mass
      square = alpha*alpha
      if (present(omega)) then
        beta_squared = (square - omega)*(square + omega)   ! α⁴ − ω² without cancellation, Eq. 2
      else
        beta_squared = square*square                       ! Eq. 3
      end if
      if (first == 1) modes%critical_speed = square(1)     ! ω = hP₁², for the lowest of them
      modes%phase_velocity(first:last) = phase_velocity(shape%alpha, beta_squared)
      modes%group_velocity(first:last) = group_velocity(shape%alpha, beta_squared)
    end associate
  end subroutine set_some

  pure function closed_form_shapes(self, first, last, xi) result(values)
    class(closed_form_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    if (knows(self, xi)) then
      values = self%known(first:last, :)
    else
      values = values_of_shapes(self%root(first:last), xi)
    end if
  end function closed_form_shapes

  pure function values_of_shapes(root, xi) result(values)
    !! Φ_k(ξ) from the roots.
    type(root_type), intent(in) :: root(:)
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(size(root), size(xi))
    type(shape_type) :: shape(chunk)
    integer :: k, last, p
    do k = 1, size(root), chunk
      last = min(k + chunk - 1, size(root))
      shape(:last - k + 1) = shapes_of(root(k:last))
      do p = 1, size(xi)
        values(k:last, p) = shape_values(shape(:last - k + 1), xi(p))
      end do
    end do
  end function values_of_shapes

  pure logical function knows(self, xi)
    !! The shapes at these points.
    class(closed_form_set), intent(in) :: self
    real(dp), intent(in) :: xi(:)
    knows = allocated(self%known)
    if (knows) knows = size(self%known_at) == size(xi)
    if (knows) knows = all(self%known_at == xi)
  end function knows

  pure function overlap_with_mass(self, from, amplitude) result(sums)
    class(closed_form_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! in closed form, of the beam alone
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(self%count)
    integer :: first, last
    select type (from)
    class is (closed_form_set)
      associate (free => shapes_in_parts(from%root))
        do first = 1, self%count, chunk
          last = min(first + chunk - 1, self%count)
          sums(first:last) = overlap_with_tip_mass(shapes_of(self%root(first:last)), free, amplitude)
        end do
      end associate
    class default
      error stop 'bw_closed_form: modes found in different ways have no overlap'
    end select
  end function overlap_with_mass

  pure function overlap_of_beam(self, from, amplitude) result(sums)
    class(closed_form_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! in closed form; one of the two is of the beam alone
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(self%count)
    integer :: first, last
    select type (from)
    class is (closed_form_set)
      associate (shape => shapes_in_parts(from%root))
        do first = 1, self%count, chunk
          last = min(first + chunk - 1, self%count)
          sums(first:last) = overlap_without_mass(shapes_of(self%root(first:last)), shape, amplitude)
        end do
      end associate
    class default
      error stop 'bw_closed_form: modes found in different ways have no overlap'
    end select
  end function overlap_of_beam

  pure function overlap_far_below(self, from, amplitude) result(sums)
    !! ∫Φ̄_kφ_i dξ = γᾱ_k⁴Φ̄_k(1)φ_i(1)/(α_i⁴ − ᾱ_k⁴) for ᾱ_k ≪ α_i: the force at the tip, and how far it bends the beam.
    class(closed_form_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! of beam and mass
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(self%count)
    sums = (from%gamma*sum(from%alpha**4*from%tip*amplitude))*self%tip/self%alpha**4
  end function overlap_far_below

  pure function shapes_in_parts(root) result(shape)
    !! `shapes_of` of many, whose work then takes no memory.
    type(root_type), intent(in) :: root(:)
    type(shape_type) :: shape(size(root))
    integer :: first, last
    do first = 1, size(root), chunk
      last = min(first + chunk - 1, size(root))
      shape(first:last) = shapes_of(root(first:last))
    end do
  end function shapes_in_parts

  pure type(closed_form_source) function source_in_closed_form(gamma, omega) result(source)
    !! All modes of a uniform beam with a mass at its tip, up to `highest_mode`.
    real(dp), intent(in) :: gamma                  !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega        !! in-plane angular velocity in h/l²; absent: none acts on the modes
    source%gamma = gamma
    source%highest = highest_mode
    source%quadratic = .true.
    if (present(omega)) source%omega = omega
  end function source_in_closed_form

  subroutine find_in_closed_form(self, number, modes, longest)
    class(closed_form_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    type(closed_form_set), allocatable :: found
    integer :: place
    logical :: is_kept
    allocate (found)
    is_kept = .false.
    if (associated(self%kept)) is_kept = self%kept%takes(number)
    if (is_kept) then
      call self%kept%place(size(number), self%gamma, place)
      call set_kept_modes(self%kept%sets(place), self%points, self%omega, longest, found)
    else
      call set_modes(number, self%gamma, self%omega, longest, found)
    end if
    call found%damp(self%damping)
    call move_alloc(found, modes)
  end subroutine find_in_closed_form

  pure function closed_form_elastic(self) result(squares)
    !! α⁴, Eq. 28.
    class(closed_form_set), intent(in) :: self
    real(dp) :: squares(self%count)
    squares = self%alpha**4
  end function closed_form_elastic

  subroutine terms_in_closed_form(self, number, xi, longest, beta, drive, shapes)
    !! Runs of far modes by interpolation, other far ones in their short form, the others through a set.
    class(closed_form_source), intent(in) :: self
    integer, intent(in) :: number(:)
    real(dp), intent(in) :: xi(:)
    real(dp), intent(in), optional :: longest
    type(dd), intent(out) :: beta(:)
    real(dp), intent(out) :: drive(:), shapes(:, :)
    integer :: first, light, n, near
    logical :: found
    if (present(longest)) then
      if (is_far_run(number, self%gamma, self%omega, xi)) then
        call far_run_terms(number(1), self%gamma, self%omega, xi, longest, beta, drive, shapes, found)
        if (found) return
      end if
    end if
    n = size(number)
    near = max(near_modes(number, self%gamma), count(number <= modes_of_series(xi)))
    light = max(near, light_modes(number, self%gamma))
    if (near > 0) call terms_of_set(self, number(:near), xi, longest, beta(:near), drive(:near), shapes(:near, :))
    do first = near + 1, light, chunk
      associate (last => min(first + chunk - 1, light))
        call add_far(first, last, .true.)
      end associate
    end do
    do first = light + 1, n, chunk
      associate (last => min(first + chunk - 1, n))
        call add_far(first, last, .false.)
      end associate
    end do
  contains
    subroutine add_far(first, last, light)
      !! From those that cases share, if no phases are asked for and there is room.
      integer, intent(in) :: first, last
      logical, intent(in) :: light
      logical :: is_kept
      associate (k => number(first:last))
        is_kept = associated(self%kept) .and. .not. present(longest)
        if (is_kept) is_kept = self%kept%terms%takes(k, xi)
        if (is_kept) then
          call self%kept%terms%terms(k, self%gamma, light, self%omega, xi, beta(first:last), drive(first:last), &
                                     shapes(first:last, :))
        else
          call far_terms(k, self%gamma, light, self%omega, xi, longest, beta(first:last), drive(first:last), &
                         shapes(first:last, :))
        end if
      end associate
    end subroutine add_far
  end subroutine terms_in_closed_form

  pure integer function modes_of_series(xi) result(k)
    !! The highest mode that needs its power series, αξ < ½, at one of the points.
    real(dp), intent(in) :: xi(:)
    real(dp) :: alpha
    alpha = 0.5_dp/minval(xi, mask=xi > 0.0_dp)
    k = int(min(real(highest_mode, dp), alpha/acos(-1.0_dp) + 2.0_dp))
  end function modes_of_series

end module bw_closed_form
