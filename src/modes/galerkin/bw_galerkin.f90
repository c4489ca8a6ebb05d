module bw_galerkin
  !! Modes of a beam whose shapes have no closed form: with tension, with shear, or with a body at the tip that has
  !! rotary inertia.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_critical_speed, only: critical_speed_of
  use bw_double_double, only: dd, to_dd, operator(*), operator(-), operator(/)
  use bw_galerkin_set, only: galerkin_set, tip_body
  use bw_local_waves, only: find_waves
  use bw_missing, only: missing
  use bw_monitor, only: monitor_type
  use bw_rayleigh, only: elastic_part, rotation_part
  use bw_strain_basis, only: tip_value
  use bw_strain_modes, only: solve_strain_modes, strain_modes
  implicit none (type, external)
  private
  public :: galerkin_modes

  real(dp), parameter :: heavy = 1.0e-4_dp
    !! γ from which √γ v(1) carries more digits of v(1) than the sum of its coefficients

contains

  subroutine galerkin_modes(operator, count, set, monitor)
    !! The first `count` modes.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count                   !! ≥ 1
    type(galerkin_set), intent(out) :: set
    class(monitor_type), intent(inout), optional :: monitor   !! none are found where it asks to stop
    type(strain_modes) :: modes
    integer :: rows
    call solve_strain_modes(operator, count, modes, monitor)
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
    set%tip = tip_values(operator%gamma, modes)
    call normalise(set)
    allocate (set%alpha(count), set%phase_velocity(count), set%group_velocity(count))
    call find_waves(operator, set%beta_squared, set%alpha, set%phase_velocity, set%group_velocity)
    set%critical_speed = critical_speed_of(operator)
  end subroutine galerkin_modes

  pure subroutine find_squares(operator, modes, set)
    !! β² from the singular values, or from Rayleigh's quotient where the shift would leave a small difference. Where the two
    !! do not agree the modes are not what they should be.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    type(galerkin_set), intent(inout) :: set
    real(dp), parameter :: agreement = 1.0e-8_dp
    real(dp), dimension(size(modes%period)) :: quotient, scale
    set%rotation = rotation_part(operator, modes)
    set%beta_squared = squares_of(modes%period, modes%system%shift)
    quotient = elastic_part(modes) + set%rotation
    scale = abs(set%beta_squared%hi) + modes%system%shift%hi
    set%resolved = all(abs(quotient - set%beta_squared%hi) <= agreement*scale)
    where (abs(set%beta_squared%hi) < 0.5_dp*modes%system%shift%hi) set%beta_squared = to_dd(quotient)
  end subroutine find_squares

  pure subroutine leave_empty(set)
    !! A set whose modes could not be found: arrays of the right lengths, in which nothing moves.
    type(galerkin_set), intent(inout) :: set
    integer :: n
    n = set%count
    allocate (set%alpha(n), set%phase_velocity(n), set%group_velocity(n), source=missing)
    allocate (set%modal_mass(n), source=1.0_dp)
    allocate (set%tip(n), set%deflection(2, n), set%strain(2, n), source=0.0_dp)
    set%beta_squared = spread(dd(), 1, n)
    set%rotation = spread(0.0_dp, 1, n)
  end subroutine leave_empty

  pure type(tip_body) function body_of(operator) result(body)
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
    !! From norm 1 of all that moves to ∫Φ² dξ = 1.
    type(galerkin_set), intent(inout) :: set
    real(dp) :: scale
    integer :: k
    allocate (set%modal_mass(set%count))
    do k = 1, set%count
      scale = 1.0_dp/norm2(set%deflection(:, k))
      set%modal_mass(k) = scale**2
      if (mod(k, 2) == 0 .neqv. set%tip(k) > 0.0_dp) scale = -scale
      if (scale < 0.0_dp) set%strain(:, k) = -set%strain(:, k)
      set%tip(k) = scale*set%tip(k)
      set%deflection(:, k) = scale*set%deflection(:, k)
      if (allocated(set%turning)) set%turning(:, k) = scale*set%turning(:, k)
    end do
  end subroutine normalise

  elemental type(dd) function squares_of(period, shift) result(beta_squared)
    real(dp), intent(in) :: period
    type(dd), intent(in) :: shift
    type(dd) :: p
    p = to_dd(period)
    beta_squared = to_dd(1.0_dp)/(p*p) - shift
  end function squares_of

end module bw_galerkin
