module bw_closed_form
  !! The modes of a uniform clamped beam with a tip mass, rotating without tension: Eqs 7–9 and 18–21.
  use bw_kinds, only: dp, qp
  use bw_double_double, only: dd, to_dd, to_quad, operator(*), operator(+), operator(-)
  use bw_far_runs, only: far_run_terms, is_far_run
  use bw_far_terms, only: far_terms
  use bw_frequency_equation, only: highest_mode, root_type
  use bw_kept_modes, only: chunk, kept_modes, kept_set
  use bw_mode_set, only: full_numbers, mode_set, mode_source, terms_of_set
  use bw_monitor, only: monitor_type, stops
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
    type(dd), allocatable :: omega                 !! in-plane angular velocity in h/l²; unallocated: none
    real(dp), allocatable :: known_at(:)           !! points where they are known already; unallocated: none
    real(dp), allocatable :: known(:, :)           !! Φ_k there, (n, points)
  contains
    procedure :: some_shapes => closed_form_shapes
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: overlap_far_below
    procedure :: elastic => closed_form_elastic
    procedure :: in_full => closed_form_in_full
  end type closed_form_set

  type, extends(mode_source), public :: closed_form_source
    type(dd) :: mass_ratio                         !! γ to all digits
    type(dd), allocatable :: omega                 !! in-plane angular velocity in h/l²; absent: none
    type(kept_modes), pointer :: kept => null()    !! what cases share; not associated: nothing is kept
  contains
    procedure :: find => find_in_closed_form
    procedure :: terms => terms_in_closed_form
  end type closed_form_source

  interface source_in_closed_form
    module procedure :: source_of_number, source_of_ratio
  end interface source_in_closed_form

contains

  type(closed_form_set) function closed_form_modes(count, gamma, omega, longest) result(modes)
    !! The first `count` modes; γ = 0 is the beam alone.
    integer, intent(in) :: count           !! ≥ 1
    real(dp), intent(in) :: gamma          !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
    real(dp), intent(in), optional :: longest
    integer :: k
    call set_modes([(k, k=1, count)], to_dd(gamma), omega, longest, modes)
  end function closed_form_modes

  subroutine set_modes(number, gamma, omega, longest, modes, monitor)
    !! Modes of any numbers, in their order.
    integer, intent(in) :: number(:)       !! k ≥ 1, ascending
    type(dd), intent(in) :: gamma          !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
      !! in-plane angular velocity in units of h/l²; absent: no rotation acts on the modes
    real(dp), intent(in), optional :: longest
      !! the longest time, in l²/h, after which phases must still be right; absent: no history is asked for
    type(closed_form_set), intent(out) :: modes
    class(monitor_type), intent(inout), optional :: monitor   !! the modes mean nothing where it asks to stop
    type(shape_type) :: shape(chunk)
    type(dd) :: alpha(chunk)
    integer :: first, last, m
    call size_set(size(number), gamma%hi, omega, modes)
    do first = 1, size(number), chunk
      last = min(first + chunk - 1, size(number))
      m = last - first + 1
      shape(:m) = shapes_of(solve_roots(number(first:last), gamma%hi))
      shape(:m)%root%gamma_low = gamma%lo
      alpha(:m) = root_values(shape(:m)%root)
      call refine_roots(shape(:m)%root, is_coarse(shape(:m)%root%rest, alpha(:m)%hi, omega, longest), alpha(:m))
      call set_some(first, last, shape(:m), alpha(:m), omega, modes)
      if (present(monitor)) call monitor%advance(real(last, dp)/size(number))
      if (stops(monitor)) return
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
    call size_set(size(kept%shape), kept%gamma%hi, omega, modes)
    modes%kept_as = kept%number
    if (present(points)) call kept%shapes_at(points, modes%known)
    if (allocated(modes%known)) modes%known_at = points
    call kept%roots(omega, longest, alpha)
    do first = 1, modes%count, chunk
      last = min(first + chunk - 1, modes%count)
      call set_some(first, last, kept%shape(first:last), alpha(first:last), omega, modes)
    end do
  end subroutine set_kept_modes

  pure subroutine size_set(n, gamma, omega, modes)
    integer, intent(in) :: n
    real(dp), intent(in) :: gamma
    type(dd), intent(in), optional :: omega
    type(closed_form_set), intent(inout) :: modes
    modes%count = n
    modes%gamma = gamma
    if (present(omega)) modes%omega = omega
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

  function overlap_with_mass(self, from, amplitude, monitor) result(sums)
    class(closed_form_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! in closed form, of the beam alone
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    select type (from)
    class is (closed_form_set)
      sums = overlap_with_tip_mass(self%root, from%root(:size(amplitude)), amplitude, monitor)
    class default
      error stop 'bw_closed_form: modes found in different ways have no overlap'
    end select
  end function overlap_with_mass

  function overlap_of_beam(self, from, amplitude, monitor) result(sums)
    class(closed_form_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! in closed form; one of the two is of the beam alone
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    select type (from)
    class is (closed_form_set)
      sums = overlap_without_mass(self%root, from%root(:size(amplitude)), amplitude, monitor)
    class default
      error stop 'bw_closed_form: modes found in different ways have no overlap'
    end select
  end function overlap_of_beam

  pure function overlap_far_below(self, from, amplitude) result(sums)
    !! ∫Φ̄_kφ_i dξ = γᾱ_k⁴Φ̄_k(1)φ_i(1)/(α_i⁴ − ᾱ_k⁴) for ᾱ_k ≪ α_i, two terms of its series in (ᾱ_k/α_i)⁴: the force at the
    !! tip, and how far it bends the beam.
    class(closed_form_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! of beam and mass
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(self%count), force(from%count)
    force = from%gamma*from%alpha**4*from%tip*amplitude
    sums = (sum(force) + sum(force*from%alpha**4)/self%alpha**4)*self%tip/self%alpha**4
  end function overlap_far_below

  pure type(closed_form_source) function source_of_number(gamma, omega) result(source)
    !! The same for a mass ratio that is a binary64 number.
    real(dp), intent(in) :: gamma                  !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
    source = source_of_ratio(to_dd(gamma), omega)
  end function source_of_number

  pure type(closed_form_source) function source_of_ratio(gamma, omega) result(source)
    !! All modes of a uniform beam with a mass at its tip, up to `highest_mode`.
    type(dd), intent(in) :: gamma                  !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega        !! in-plane angular velocity in h/l²; absent: none acts on the modes
    source%gamma = gamma%hi
    source%mass_ratio = gamma
    source%highest = highest_mode
    source%quadratic = .true.
    if (present(omega)) source%omega = omega
  end function source_of_ratio

  subroutine find_in_closed_form(self, number, modes, longest, monitor)
    class(closed_form_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    type(closed_form_set), allocatable :: found
    integer :: place
    logical :: is_kept
    allocate (found)
    is_kept = .false.
    if (associated(self%kept)) is_kept = self%kept%takes(number)
    if (is_kept) then
      call self%kept%place(size(number), self%mass_ratio, place)
      call set_kept_modes(self%kept%sets(place), self%points, self%omega, longest, found)
    else
      call set_modes(number, self%mass_ratio, self%omega, longest, found, monitor)
    end if
    call found%damp(self%damping)
    call move_alloc(found, modes)
  end subroutine find_in_closed_form

  pure function closed_form_elastic(self) result(squares)
    !! α⁴, Eq. 28, of the roots that β² has, refined or not.
    class(closed_form_set), intent(in) :: self
    type(dd) :: squares(self%count)
    squares = self%beta_squared
    if (allocated(self%omega)) squares = squares + self%omega*self%omega
  end function closed_form_elastic

  pure subroutine closed_form_in_full(self, numbers)
    !! Of modes whose roots were all refined (`longest` without end): the digits of double-double numbers. Without a mass
    !! at the tip M = Φ(1)²/4, whatever the rounding of Φ(1).
    class(closed_form_set), intent(in) :: self
    type(full_numbers), intent(out) :: numbers
    real(dp), parameter :: relative_error = 2.0e-32_dp     ! of β²; of 200 modes within 8e-32
    type(dd) :: elastic(self%count)
    elastic = self%elastic()
    numbers%square = to_quad(self%beta_squared)
    numbers%square_error = relative_error*elastic%hi
    numbers%mass = real(self%tip, qp)**2/4
    numbers%mass_error = 0.0_dp*self%tip
    if (self%gamma > 0.0_dp) then
      numbers%mass = real(self%modal_mass, qp)
      numbers%mass_error = 1.0e-14_dp + numbers%mass_error
    end if
    numbers%damping = 0.0_qp*numbers%square
    if (allocated(self%law)) then                ! α_k⁴ = β_k² + ω², and α² of the first is the critical speed
      numbers%damping = self%law%rates(numbers%square + (to_quad(self%critical_speed)**2 - numbers%square(1)))
    end if
    numbers%damping_error = relative_error*real(numbers%damping, dp)
  end subroutine closed_form_in_full

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
        call far_run_terms(number(1), self%mass_ratio, self%omega, xi, longest, beta, drive, shapes, found)
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
          call far_terms(k, self%mass_ratio, light, self%omega, xi, longest, beta(first:last), drive(first:last), &
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
