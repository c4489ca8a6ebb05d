module bw_closed_form
  !! The modes of a uniform clamped beam with a tip mass, rotating without tension: Eqs 7–9 and 18–21, with the velocities of
  !! their waves, Eqs 32 and 33. Without dimensions: lengths in l, times in l²/h, velocities in h/l.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, to_dd, operator(*), operator(+), operator(-)
  use bw_frequency_equation, only: root_type
  use bw_missing, only: missing, no_number
  use bw_mode_cache, only: cached_set, shape_table
  use bw_mode_set, only: batch, mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_overlap, only: overlap_with_tip_mass, overlap_without_mass
  use bw_refined_root, only: is_coarse, refine_roots
  use bw_root_list, only: root_values, solve_roots
  use bw_shape, only: curvature_values, shape_type, shapes_of, shape_values, slope_values
  implicit none (type, external)
  private
  public :: closed_form_modes, find_modes, find_cached_modes
  public :: phase_velocity, group_velocity           ! for their own tests

  type, extends(mode_set), public :: closed_form_set
    type(root_type), allocatable :: root(:)        !! roots, from which shapes follow, (n)
    type(dd), allocatable :: omega                 !! in-plane angular velocity in h/l²; unallocated: none
    type(shape_table), private :: known            !! stored shapes of all modes
  contains
    procedure :: some_shapes => closed_form_shapes
    procedure :: some_curvatures => closed_form_curvatures
    procedure :: overlap
    procedure :: elastic => closed_form_elastic
    procedure :: motion_at
    procedure :: share_of_turn
    procedure :: number_errors => closed_form_errors
  end type closed_form_set

contains

  type(closed_form_set) function closed_form_modes(count, gamma, omega, longest) result(modes)
    !! Return the first `count` modes; γ = 0 is the beam alone.
    integer, intent(in) :: count           !! ≥ 1
    real(dp), intent(in) :: gamma          !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
    real(dp), intent(in), optional :: longest
    integer :: k
    call find_modes([(k, k=1, count)], to_dd(gamma), omega, longest, modes)
  end function closed_form_modes

  subroutine find_modes(number, gamma, omega, longest, modes, monitor)
    !! Find modes with given numbers, in that order.
    integer, intent(in) :: number(:)       !! k ≥ 1, ascending
    type(dd), intent(in) :: gamma          !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
      !! in-plane angular velocity in h/l²; absent: no effect of rotation on the modes
    real(dp), intent(in), optional :: longest
      !! time, in l²/h, up to which phases are accurate; absent: no history is requested
    type(closed_form_set), intent(out) :: modes
    class(monitor_type), intent(inout), optional :: monitor   !! the modes are invalid if it requests a stop
    type(shape_type) :: shape(batch)
    type(dd) :: alpha(batch)
    integer :: first, last, m
    call allocate_set(size(number), gamma%hi, omega, modes)
    modes%known_by_mass = maxval(number) == size(number)
    do first = 1, size(number), batch
      last = min(first + batch - 1, size(number))
      m = last - first + 1
      shape(:m) = shapes_of(solve_roots(number(first:last), gamma%hi))
      shape(:m)%root%gamma_low = gamma%lo
      alpha(:m) = root_values(shape(:m)%root)
      call refine_roots(shape(:m)%root, is_coarse(shape(:m)%root%remainder, alpha(:m)%hi, omega, longest), alpha(:m))
      call set_range(first, last, shape(:m), alpha(:m), omega, modes)
      if (present(monitor)) call monitor%advance(real(last, dp)/size(number))
      if (stops(monitor)) return
    end do
  end subroutine find_modes

  pure subroutine find_cached_modes(cached, omega, longest, points, modes)
    !! Find the modes of a cached set.
    type(cached_set), intent(inout) :: cached
    type(dd), intent(in), optional :: omega
    real(dp), intent(in), optional :: longest
    real(dp), intent(in), optional :: points(:)    !! ξ at which shapes of all modes will be needed
    type(closed_form_set), intent(out) :: modes
    type(dd) :: alpha(size(cached%shape))
    integer :: first, last
    call allocate_set(size(cached%shape), cached%gamma%hi, omega, modes)
    modes%known_by_mass = .true.
    call cached%roots(omega, longest, alpha)
    do first = 1, modes%count, batch
      last = min(first + batch - 1, modes%count)
      call set_range(first, last, cached%shape(first:last), alpha(first:last), omega, modes)
    end do
    if (.not. present(points)) return
    if (.not. cached%at_points%is_of(points)) then
      if (cached%at_points%has_room_for(modes%count, points)) cached%at_points = shape_table(points, modes%shapes(points))
    end if
    modes%known = cached%at_points
  end subroutine find_cached_modes

  pure subroutine allocate_set(n, gamma, omega, modes)
    !! Allocate the arrays of n modes, and set their common data.
    integer, intent(in) :: n
    real(dp), intent(in) :: gamma
    type(dd), intent(in), optional :: omega
    type(closed_form_set), intent(inout) :: modes
    modes%count = n
    modes%gamma = gamma
    if (present(omega)) modes%omega = omega
    allocate (modes%root(n), modes%alpha(n), modes%struck(n), modes%modal_mass(n), modes%beta_squared(n))
    allocate (modes%phase_velocity(n), modes%group_velocity(n))
  end subroutine allocate_set

  pure subroutine set_range(first, last, shape, alpha, omega, modes)
    !! Set the modes `first` … `last` of a set.
    integer, intent(in) :: first, last
    type(shape_type), intent(in) :: shape(:)
    type(dd), intent(in) :: alpha(:)
    type(dd), intent(in), optional :: omega
    type(closed_form_set), intent(inout) :: modes
    type(dd) :: square(last - first + 1)
    associate (beta_squared => modes%beta_squared(first:last))
      modes%root(first:last) = shape%root
      modes%alpha(first:last) = shape%alpha
      modes%struck(first:last) = shape%tip
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
  end subroutine set_range

  ! Waves

  elemental real(dp) function phase_velocity(alpha, beta_squared) result(velocity)
    !! Return C_p = β/P (Eq. 32); missing for an unstable mode, 0 at its critical speed.
    real(dp), intent(in) :: alpha           !! wave number P l > 0
    type(dd), intent(in) :: beta_squared    !! β² = α⁴ − ω², in (h/l²)²
    velocity = missing
    if (beta_squared%hi < 0.0_dp) return
    velocity = sqrt(beta_squared%hi)/alpha
  end function phase_velocity

  elemental real(dp) function group_velocity(alpha, beta_squared) result(velocity)
    !! Return C_g = dβ/dP = 2α³/β (Eq. 33); missing for an unstable mode and at its critical speed.
    real(dp), intent(in) :: alpha
    type(dd), intent(in) :: beta_squared
    velocity = missing
    if (beta_squared%hi <= 0.0_dp) return
    velocity = 2.0_dp*alpha*(alpha**2/sqrt(beta_squared%hi))
  end function group_velocity

  ! Functions of a set

  pure function closed_form_shapes(self, first, last, xi) result(values)
    !! Return Φ_k(ξ), stored or from the roots.
    class(closed_form_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    if (size(values, 1) == self%count .and. self%known%is_of(xi)) then
      values = self%known%values
    else
      values = shapes_of_roots(self%root(first:last), xi)
    end if
  end function closed_form_shapes

  pure function shapes_of_roots(root, xi) result(values)
    !! Return Φ_k(ξ) of the modes of given roots.
    type(root_type), intent(in) :: root(:)
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(size(root), size(xi))
    type(shape_type) :: shape(min(batch, size(root)))
    integer :: k, n, p
    do k = 1, size(root), batch
      n = min(batch, size(root) - k + 1)
      shape(:n) = shapes_of(root(k:k + n - 1))
      do p = 1, size(xi)
        values(k:k + n - 1, p) = shape_values(shape(:n), xi(p))
      end do
    end do
  end function shapes_of_roots

  pure function closed_form_curvatures(self, first, last, xi) result(values)
    !! Return Φ_k''(ξ) from the roots; at the clamped end −2α² for any mass.
    class(closed_form_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    values = spread(-2.0_dp*self%alpha(first:last)**2, 2, size(xi))
    if (any(xi /= 0.0_dp)) call find_curvatures(self%root(first:last), xi, values)
  end function closed_form_curvatures

  pure subroutine find_curvatures(root, xi, values)
    type(root_type), intent(in) :: root(:)
    real(dp), intent(in) :: xi(:)
    real(dp), intent(out) :: values(:, :)
    type(shape_type) :: shape(batch)
    integer :: k, n, p
    do k = 1, size(root), batch
      n = min(batch, size(root) - k + 1)
      shape(:n) = shapes_of(root(k:k + n - 1))
      do p = 1, size(xi)
        values(k:k + n - 1, p) = curvature_values(shape(:n), xi(p))*shape(:n)%alpha**2
      end do
    end do
  end subroutine find_curvatures

  pure function motion_at(self, xi) result(motion)
    !! Return deflection and slope.
    class(closed_form_set), intent(in) :: self
    real(dp), intent(in) :: xi
    real(dp) :: motion(self%count, 2)
    type(shape_type) :: shape(batch)
    integer :: k, n
    motion(:, 1:1) = self%some_shapes(1, self%count, [xi])
    do k = 1, self%count, batch
      n = min(batch, self%count - k + 1)
      shape(:n) = shapes_of(self%root(k:k + n - 1))
      motion(k:k + n - 1, 2) = slope_values(shape(:n), xi)*shape(:n)%alpha
    end do
  end function motion_at

  pure function share_of_turn(self) result(share)
    !! Return ∫ξΦ dξ + γΦ(1) = Φ''(0)/α⁴, by parts: the tip has no moment, and Φ'''(1) = −γα⁴Φ(1).
    class(closed_form_set), intent(in) :: self
    real(dp) :: share(self%count)
    share = -2.0_dp/self%alpha**2
  end function share_of_turn

  function overlap(self, from, amplitude, with_mass, monitor) result(sums)
    !! Return Σ_i a_i(∫Φ_kφ_i dξ + γΦ_k(1)φ_i(1)), Eq. 26 times M̄_k, or Σ_i a_i∫Φ_kφ_i dξ.
    class(closed_form_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! in closed form; one of the two sets, with mass this one, is of the beam alone
    real(dp), intent(in) :: amplitude(:)
    logical, intent(in) :: with_mass
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    select type (from)
    class is (closed_form_set)
      if (with_mass) then
        sums = overlap_with_tip_mass(self%root, from%root(:size(amplitude)), amplitude, monitor)
      else
        sums = overlap_without_mass(self%root, from%root(:size(amplitude)), amplitude, monitor)
      end if
    class default
      sums = no_number()
    end select
  end function overlap

  pure function closed_form_elastic(self) result(squares)
    !! Return α⁴, Eq. 28, of the same roots, refined or not, as for β².
    class(closed_form_set), intent(in) :: self
    type(dd) :: squares(self%count)
    squares = self%beta_squared
    if (allocated(self%omega)) squares = squares + self%omega*self%omega
  end function closed_form_elastic

  pure subroutine closed_form_errors(self, square_error, mass_error)
    !! Return the errors of β² and M. Roots that were all refined (infinite `longest`) have double-double digits.
    !! Without a tip mass M = Φ(1)²/4, whatever the rounding of Φ(1).
    class(closed_form_set), intent(in) :: self
    real(dp), intent(out) :: square_error(:), mass_error(:)
    type(dd) :: elastic(self%count)
    elastic = self%elastic()
    square_error = 1.0e-31_dp*elastic%hi
    mass_error = merge(1.0e-14_dp, 0.0_dp, self%gamma > 0.0_dp)
  end subroutine closed_form_errors

end module bw_closed_form
