module bw_strain_squares
  !! The squares β² of the frequencies of modes by strains, from the singular values and from Rayleigh's quotient.
  use bw_double_double, only: dd, to_dd, operator(*), operator(-), operator(/)
  use bw_kinds, only: dp
  use bw_strain_basis, only: times_polynomial
  use bw_strain_set, only: strain_set
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: find_squares

contains

  pure subroutine find_squares(given, period, shift, set)
    !! Find β² of modes of mass 1. Terms of rotation are about Ω², and what rounding leaves of their cancellation is set
    !! to 0, as for a beam that rotates freely about the axis of rotation.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: period(:)
    type(dd), intent(in) :: shift                  !! σ
    type(strain_set), intent(inout) :: set
    real(dp), parameter :: rest = 16.0_dp*epsilon(1.0_dp)
    real(dp) :: quotient(set%count)
    type(dd) :: p
    integer :: k
    allocate (set%beta_squared(set%count), set%rotation(set%count), set%modal_mass(set%count))
    set%modal_mass = 1.0_dp
    do k = 1, set%count
      p = to_dd(period(k))
      set%beta_squared(k) = to_dd(1.0_dp)/(p*p) - shift
      set%rotation(k) = rotation_term(given, set, k)
      quotient(k) = set%work(k, k) + set%rotation(k)
    end do
    call choose_squares(quotient, shift%hi, set)
    if (given%beam%root%on_hub) set%beta_squared(1) = dd()       ! rigid rotation
    where (abs(set%beta_squared%hi) <= rest*given%beam%spin_squared%hi) set%beta_squared = dd()
  end subroutine find_squares

  pure subroutine choose_squares(quotient, shift, set)
    !! Choose β² between that of the singular values, in the set, and Rayleigh's quotient. The former is a small
    !! difference if the shift or the terms of rotation are larger. In a badly conditioned system, as with very
    !! different springs, its error is the difference of the two, as that of the quotient is the square of a shape's
    !! error. If the two disagree the modes are not resolved.
    real(dp), intent(in) :: quotient(:)            !! (modes)
    real(dp), intent(in) :: shift                  !! σ ≥ 0
    type(strain_set), intent(inout) :: set
    real(dp), parameter :: agreement = 1.0e-8_dp
    real(dp), parameter :: conditioned = 2.0e-14_dp       ! tuned: largest difference in a well-conditioned system
    real(dp), parameter :: rounding = 16.0_dp*epsilon(1.0_dp)   ! of all terms otherwise, by comparison with power series
    real(dp), dimension(size(quotient)) :: scale, difference
    scale = shift + (quotient - set%rotation) + abs(set%rotation)
    difference = abs(quotient - set%beta_squared%hi)
    set%resolved = all(difference <= agreement*scale)
    set%square_rounding = max(rounding*scale, min(difference, conditioned*scale))
    where (abs(set%beta_squared%hi) < 0.5_dp*scale .or. difference > conditioned*scale) set%beta_squared = to_dd(quotient)
  end subroutine choose_squares

  pure real(dp) function rotation_term(given, set, k) result(term)
    !! Return the work against tension, less Ω² times the mass or inertia on which the centrifugal force acts.
    type(varying_beam), intent(in) :: given
    type(strain_set), intent(in) :: set
    integer, intent(in) :: k
    integer :: i
    term = 0.0_dp
    do i = 1, size(set%piece)
      associate (piece => given%beam%piece(i), law => given%law(i), motion => set%piece(i))
        term = term + piece%length%hi*weighed(law%tension, motion%slope(:, k))
        if (given%beam%in_plane) then
          term = term - piece%mass%hi*piece%length%hi*weighed(law%mass, motion%deflection(:, k))
        else
          term = term - piece%rotary%hi*piece%length%hi*weighed(law%rotary, motion%turning(:, k))
        end if
        term = term + given%beam%joint(i)%mass%hi*body_term(given, set, k, i)
      end associate
    end do
    term = given%beam%spin_squared%hi*term
  end function rotation_term

  pure real(dp) function weighed(law, f) result(integral)
    !! Return ∫w f² over a piece, per length.
    real(dp), intent(in) :: law(:)                 !! of w
    real(dp), intent(in) :: f(:)                   !! coefficients
    integral = dot_product(f, times_polynomial(law, f))
  end function weighed

  pure real(dp) function body_term(given, set, k, joint) result(term)
    !! Return the term of a body's mass at ξ_b: with tension (R + ξ_b)∫v'² dξ up to there, in plane less v(ξ_b)². With
    !! the mean slope s, v(ξ_b) = v(0) + sξ_b, both are (R + ξ_b)∫(v' − s)² + Rs²ξ_b − v(0)(v(0) + 2sξ_b), without
    !! cancellation at a fixed root, for any mass.
    type(varying_beam), intent(in) :: given
    type(strain_set), intent(in) :: set
    integer, intent(in) :: k, joint
    real(dp) :: mean, place
    integer :: i
    term = 0.0_dp
    associate (v => set%deflection(:, k), in_plane => given%beam%in_plane, hub => given%hub_radius)
      if (.not. given%is_pulled) then
        if (in_plane) term = -v(joint + 1)**2
        return
      end if
      place = sum(given%beam%piece(:joint)%length%hi)
      mean = 0.0_dp
      if (in_plane) mean = (v(joint + 1) - v(1))/place
      do i = 1, joint
        associate (slope => set%piece(i)%slope(:, k))
          term = term + given%beam%piece(i)%length%hi*((slope(1) - mean)**2 + sum(slope(2:)**2))
        end associate
      end do
      term = (hub + place)*term
      if (in_plane) term = term + hub*mean**2*place - v(1)*(v(1) + 2.0_dp*mean*place)
    end associate
  end function body_term

end module bw_strain_squares
