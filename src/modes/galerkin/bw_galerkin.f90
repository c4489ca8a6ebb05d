module bw_galerkin
  !! Modes of a beam whose shapes have no closed form: with tension, with shear, or with a body at the tip that has
  !! rotary inertia.
  !!
  !! β² comes from the singular values of the strain system, and again from Rayleigh's quotient, term by term: β² = λ + what
  !! rotation adds, λ the elastic stiffness, of modes of mass 1. The quotient is wrong by the square of what a shape is wrong. It
  !! says β² where (β² + σ)^(−½) leaves it as a small difference, and where two ways to the same number agree there are digits.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_critical_speed, only: critical_speed_of
  use bw_double_double, only: dd, to_dd, operator(*), operator(-), operator(/)
  use bw_galerkin_set, only: galerkin_set, tip_body
  use bw_local_waves, only: find_waves
  use bw_missing, only: missing
  use bw_mode_demand, only: mode_demand
  use bw_monitor, only: monitor_type
  use bw_strain_basis, only: slope_of, times_quadratic, tip_value
  use bw_strain_set, only: choose_squares
  use bw_strain_modes, only: solve_strain_modes, strain_modes
  implicit none (type, external)
  private
  public :: galerkin_modes

  real(dp), parameter :: heavy = 1.0e-4_dp
    !! γ from which √γ v(1) carries more digits of v(1) than the sum of its coefficients

contains

  subroutine galerkin_modes(operator, count, set, monitor, demand)
    !! Find the first `count` modes; not `resolved`, with arrays in which nothing moves, where there are none to be had.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count                   !! ≥ 1
    type(galerkin_set), intent(out) :: set
    class(monitor_type), intent(inout), optional :: monitor   !! none are found where it asks to stop
    type(mode_demand), intent(in), optional :: demand
    type(strain_modes) :: modes
    integer :: rows
    call solve_strain_modes(operator, count, modes, monitor, demand)
    set%count = count
    set%gamma = operator%gamma
    set%body = body_of(operator)
    set%resolved = modes%resolved
    if (set%resolved) call find_squares(operator, modes, set)
    if (.not. set%resolved) then
      call leave_empty(set)
      return
    end if
    rows = modes%system%functions + 2
    set%deflection = modes%motion(:rows, :)
    if (modes%system%turn_row > 0) then
      set%turning = modes%motion(modes%system%turn_row:modes%system%turn_row + rows - 2, :)
    end if
    call move_alloc(modes%strain, set%strain)
    set%struck = tip_values(operator%gamma, modes)
    call normalise(set)
    if (present(demand)) then
      if (.not. demand%waves) return
    end if
    allocate (set%alpha(count), set%phase_velocity(count), set%group_velocity(count))
    call find_waves(operator, set%beta_squared, set%alpha, set%phase_velocity, set%group_velocity)
    set%critical_speed = critical_speed_of(operator)
  end subroutine galerkin_modes

  pure subroutine find_squares(operator, modes, set)
    !! Find β² from the singular values, or from Rayleigh's quotient where the shift would leave a small difference. Where the two
    !! do not agree the modes are not resolved.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    type(galerkin_set), intent(inout) :: set
    set%rotation = rotation_terms(operator, modes)
    set%beta_squared = squares_of(modes%period, modes%system%shift)
    call choose_squares(set, sum(modes%strain**2, dim=1) + set%rotation, modes%system%shift%hi)    ! K_kk, and rotation's part
  end subroutine find_squares

  ! What rotation adds to Rayleigh's quotient

  pure function rotation_terms(operator, modes) result(terms)
    !! β² − λ, (modes): the work against the tension, less Ω² times what of the mass the centrifugal force acts on.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    real(dp) :: terms(size(modes%period))
    real(dp) :: slope(modes%system%functions + 1), compliance
    integer :: k
    terms = 0.0_dp
    if (.not. allocated(operator%omega)) return
    slope = 0.0_dp
    compliance = 0.0_dp
    if (allocated(operator%shear)) compliance = operator%shear%compliance
    do k = 1, size(terms)
      if (allocated(operator%tension)) slope = slope_of(modes%system%functions, modes%strain(:, k), compliance)
      if (operator%in_plane) then
        terms(k) = term_in_plane(operator, modes, k, slope)
      else
        terms(k) = term_out_of_plane(operator, modes, k, slope)
      end if
    end do
  end function rotation_terms

  pure real(dp) function term_in_plane(operator, modes, k, slope) result(term)
    !! ∫Tv'² − Ω²(∫v² + γv(1)²). Of the tension the body's own share is Ω²γ(1 + R), and since v(1) is the mean of v',
    !! γ((1 + R)∫v'² − v(1)²) = γ(R∫v'² + ∫(v' − v(1))²), in which nothing cancels however heavy it is.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    integer, intent(in) :: k
    real(dp), intent(in) :: slope(:)                       !! coefficients of v', where there is tension
    real(dp) :: square, pull
    square = operator%omega%hi**2
    term = -square*sum(modes%motion(:modes%system%functions + 2, k)**2)
    if (allocated(operator%tension)) then
      pull = -operator%tension(2)                          ! Ω²R
      term = term + dot_product(slope, times_quadratic([0.5_dp*square + pull, operator%tension(2:)], slope))
      term = term + operator%gamma*(pull*sum(slope**2) + square*sum(slope(2:)**2))
    else if (modes%system%tip_row > 0) then
      term = term - square*modes%motion(modes%system%tip_row, k)**2
    end if
  end function term_in_plane

  pure real(dp) function term_out_of_plane(operator, modes, k, slope) result(term)
    !! ∫Tv'² − Ω²r²∫ψ²; a body's rotary inertia has no part.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    integer, intent(in) :: k
    real(dp), intent(in) :: slope(:)                       !! as that of `term_in_plane`
    term = 0.0_dp
    associate (row => modes%system%turn_row, n => modes%system%functions)
      if (row > 0) term = -operator%omega%hi**2*sum(modes%motion(row:row + n, k)**2)
    end associate
    if (allocated(operator%tension)) term = term + dot_product(slope, times_quadratic(operator%tension, slope))
  end function term_out_of_plane

  ! The set

  pure subroutine leave_empty(set)
    !! Make a set whose modes could not be found: arrays of the right lengths, in which nothing moves.
    type(galerkin_set), intent(inout) :: set
    integer :: n
    n = set%count
    allocate (set%alpha(n), set%phase_velocity(n), set%group_velocity(n), source=missing)
    allocate (set%modal_mass(n), source=1.0_dp)
    allocate (set%struck(n), set%deflection(2, n), set%strain(2, n), source=0.0_dp)
    set%beta_squared = spread(dd(), 1, n)
    set%rotation = spread(0.0_dp, 1, n)
  end subroutine leave_empty

  pure type(tip_body) function body_of(operator) result(body)
    !! What the energy of the body at the tip depends on.
    type(beam_operator), intent(in) :: operator
    if (allocated(operator%tip_inertia)) body%inertia = operator%tip_inertia
    if (allocated(operator%tension)) body%pull = operator%gamma*(operator%omega%hi**2 - operator%tension(2))
    if (allocated(operator%shear)) body%compliance = operator%shear%compliance
  end function body_of

  pure function tip_values(gamma, modes) result(tip)
    !! v(1) of modes of norm 1, from the row of the tip mass or from the coefficients, whichever is sharper.
    real(dp), intent(in) :: gamma
    type(strain_modes), intent(in) :: modes
    real(dp) :: tip(size(modes%period))
    integer :: k
    if (gamma > heavy) then
      tip = modes%motion(modes%system%tip_row, :)/sqrt(gamma)
    else
      tip = [(tip_value(modes%motion(:modes%system%functions + 2, k)), k=1, size(tip))]
    end if
  end function tip_values

  pure subroutine normalise(set)
    !! Scale modes from norm 1 of all that moves to ∫Φ² dξ = 1 and a tip value of sign (−1)^k.
    type(galerkin_set), intent(inout) :: set
    real(dp) :: scale
    integer :: k
    allocate (set%modal_mass(set%count))
    do k = 1, set%count
      scale = 1.0_dp/norm2(set%deflection(:, k))
      set%modal_mass(k) = scale**2
      if (mod(k, 2) == 0 .neqv. set%struck(k) > 0.0_dp) scale = -scale
      if (scale < 0.0_dp) set%strain(:, k) = -set%strain(:, k)
      set%struck(k) = scale*set%struck(k)
      set%deflection(:, k) = scale*set%deflection(:, k)
      if (allocated(set%turning)) set%turning(:, k) = scale*set%turning(:, k)
    end do
  end subroutine normalise

  elemental type(dd) function squares_of(period, shift) result(beta_squared)
    !! β² of a singular value p = (β² + σ)^(−½).
    real(dp), intent(in) :: period
    type(dd), intent(in) :: shift
    type(dd) :: p
    p = to_dd(period)
    beta_squared = to_dd(1.0_dp)/(p*p) - shift
  end function squares_of

end module bw_galerkin
