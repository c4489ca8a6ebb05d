module bw_far_modes
  !! Modes so high that sech α and 1 − tanh α are below rounding, many at a time in vector registers: β, the modal
  !! velocity per tip momentum, and shapes at points, as sums over modes need them.
  !!
  !! All but β is algebraic in the tangent of the root's remainder. With α = (k − ¾)π + δ the frequency equation is
  !! tan δ = 1/(1 + 2γα); for a light mass, γα ≲ 1, with α = (k − ½)π + δ it is tan δ = −γα/(1 + γα), which keeps the digits of
  !! a small δ. Then Φ(1) = −2√2 s sin ϑ, M/m_i = 1 + 2γ sin²ϑ, tan ϑ = 1/(1 + 2γα), s = −(−1)^k, and
  !! Φ(ξ) = √2 cos(αξ + π/4) − e^(−αξ) + ½Φ(1)e^(−α(1−ξ)).
  !!
  !! **Errors**: as those of bw_root_list and bw_shape. **Source**: Eqs 18–21 without their vanishing parts.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, rounder, sqrt, two_products, operator(*), operator(+), operator(-)
  use bw_frequency_equation, only: root_type
  use bw_refined_root, only: is_coarse, refine_roots
  implicit none (type, external)
  private
  public :: far_terms, far_roots, light_modes

  real(dp), parameter :: nothing = 45.0_dp       !! e^(−45) is below rounding of the other terms

  type, public :: far_beam
    !! The beam of the far modes, and how long phases must be accurate.
    type(dd) :: gamma                            !! mass ratio γ
    type(dd), allocatable :: omega               !! in-plane angular velocity in h/l²; unallocated: no effect
    real(dp) :: longest = 0.0_dp                 !! see `is_coarse`
  end type far_beam

contains

  pure subroutine far_terms(k, beam, xi, beta, drive, shapes, mass)
    !! Find the terms of a sum for far modes, all light or all heavy; a few hundred at a time.
    integer, intent(in) :: k(:)                  !! mode numbers, at least one
    type(far_beam), intent(in) :: beam
    real(dp), intent(in) :: xi(:)                !! ξ = 0 or αξ ≥ ½, (points)
    type(dd), intent(out) :: beta(:)             !! √|β²| with the sign of β², (modes)
    real(dp), intent(out) :: drive(:)            !! Φ_k(1)/M_k, (modes)
    real(dp), intent(out) :: shapes(:, :)        !! Φ_k(ξ), (modes, points)
    real(dp), intent(out) :: mass(:)             !! M_k, (modes)
    real(dp), dimension(size(k)) :: eighths, remainder, tangent, spread, turned, tip
    type(dd) :: alpha(size(k))
    logical :: light
    integer :: p
    light = light_modes(k(:1), beam%gamma%hi) == 1
    eighths = 4*k - merge(2, 3, light)
    call far_roots(k, beam%gamma%hi, light, remainder, tangent, spread, turned)
    call far_tip_and_drive(k, tangent, spread, turned, tip, drive)
    mass = tip/drive
    alpha = dd_pi*(0.25_dp*eighths) + remainder
    do p = 1, size(xi)
      call far_shapes(eighths, remainder, alpha%hi, tip, xi(p), shapes(:, p))
    end do
    call far_frequencies(k, beam, remainder, alpha, beta)
  end subroutine far_terms

  pure integer function light_modes(k, gamma) result(n)
    !! Count the modes with γα ≲ 1, as decided by `solve_root`; they are the first.
    integer, intent(in) :: k(:)                  !! ascending
    real(dp), intent(in) :: gamma
    n = 0
    if (size(k) == 0) return
    if (gamma <= 1.0_dp/((k(1) - 0.75_dp)*pi)) n = count(gamma <= 1.0_dp/((k - 0.75_dp)*pi))
  end function light_modes

  pure subroutine far_roots(k, gamma, light, remainder, tangent, spread, turned)
    !! Find δ of every root, and data for `far_tip_and_drive`: with A = α − δ, tan ϑ = t₀/(1 + eδ), t₀ = 1/(1 + 2γA), e = 2γt₀.
    integer, intent(in) :: k(:)                  !! mode numbers
    real(dp), intent(in) :: gamma                !! mass ratio
    logical, intent(in) :: light                 !! all anchored at (k − ½)π, else all at (k − ¾)π
    real(dp), intent(out) :: remainder(:)             !! δ
    real(dp), intent(out) :: tangent(:)          !! t₀
    real(dp), intent(out) :: spread(:)           !! e
    real(dp), intent(out) :: turned(:)           !! 1 + eδ
    real(dp), dimension(size(k)) :: anchor, start
    real(dp) :: lightness
    if (size(k) == 0) return                     ! if all are light γ may be 0
    if (light) then
      anchor = gamma*((k - 0.5_dp)*pi)           ! γA
      tangent = 1.0_dp/(1.0_dp + 2.0_dp*anchor)
      spread = 2.0_dp*gamma*tangent
      start = -anchor/(1.0_dp + anchor)
    else
      lightness = 1.0_dp/gamma
      start = 1.0_dp/(2.0_dp*pi*(k - 0.75_dp) + lightness)
      spread = 2.0_dp*start
      tangent = lightness*start
      start = tangent
    end if
    start = atan(start)
    call solve_differences(start, tangent, spread, remainder)
    turned = 1.0_dp + spread*remainder
  end subroutine far_roots

  pure subroutine solve_differences(start, tangent, spread, remainder)
    !! Solve δ + atan z = δ₀, z = e t₀δ/(1 + t₀² + eδ), the tangent at α relative to that at the anchor. With η = δ₀ − δ this is
    !! z = (a − bη)/(1 − cη); a, b and c are below 1/100, η below 1/300, and series in them are truncated below rounding.
    real(dp), intent(in) :: start(:)             !! δ₀
    real(dp), intent(in) :: tangent(:), spread(:)
    real(dp), intent(out) :: remainder(:)
    real(dp) :: a, b, c, eta, free, inverse, square, x
    integer :: i
    do i = 1, size(start)
      square = tangent(i)*tangent(i)
      inverse = 1.0_dp/(1.0_dp + square + spread(i)*start(i))
      c = spread(i)*inverse
      b = c*tangent(i)
      a = b*start(i)
      free = 1.0_dp - b*(1.0_dp - b*(1.0_dp - b*(1.0_dp - b*(1.0_dp - b*(1.0_dp - b)))))    ! 1/(1 + b)
      eta = a*free
      x = c*eta*free
      eta = eta*(1.0_dp + x*(1.0_dp + x*(2.0_dp + 5.0_dp*x)))       ! of cη² − (1 + b)η + a = 0
      eta = eta - eta**3*(1.0_dp/3.0_dp + 2.0_dp/15.0_dp*eta**2)*free*(1.0_dp + c*eta*(2.0_dp*free - 1.0_dp))
      remainder(i) = start(i) - eta
    end do
  end subroutine solve_differences

  pure subroutine far_tip_and_drive(k, tangent, spread, turned, tip, drive)
    !! Find Φ(1), and Φ(1)/M, the modal velocity per tip momentum.
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: tangent(:), spread(:), turned(:)     !! from `far_roots`
    real(dp), intent(out) :: tip(:), drive(:)
    real(dp) :: both, length, mass, square
    integer :: i
    do i = 1, size(k)
      square = turned(i)*turned(i) + tangent(i)*tangent(i)
      mass = square + spread(i)*tangent(i)                         ! M·square
      length = sqrt(square)
      both = merge(sqrt(8.0_dp), -sqrt(8.0_dp), mod(k(i), 2) == 0)*tangent(i)*length/(square*mass)
      tip(i) = both*mass
      drive(i) = both*square
    end do
  end subroutine far_tip_and_drive

  pure subroutine far_shapes(eighths, remainder, alpha, tip, xi, values)
    !! Find Φ_k(ξ) for ξ = 0 or αξ ≥ ½; whole eighths of a cycle are multiplied and reduced exactly.
    real(dp), intent(in) :: eighths(:)           !! integers; α = eighths·π/4 + remainder, ascending
    real(dp), intent(in) :: remainder(:), alpha(:), tip(:)
    real(dp), intent(in) :: xi
    real(dp), intent(out) :: values(:)
    real(dp), dimension(size(remainder)) :: whole, fraction
    if (xi == 0.0_dp .or. xi == 1.0_dp) then
      values = xi*tip
      return
    end if
    call two_products(eighths, xi, whole, fraction)
    whole = whole - 8.0_dp*((0.125_dp*whole + rounder) - rounder)
    fraction = 0.25_dp*pi*(whole + (1.0_dp + fraction)) + remainder*xi
    values = sqrt(2.0_dp)*cos(fraction)
    if (alpha(1)*xi < nothing) values = values - exp(-min(alpha*xi, nothing))
    if (alpha(1)*(1.0_dp - xi) < nothing) values = values + 0.5_dp*tip*exp(-min(alpha*(1.0_dp - xi), nothing))
  end subroutine far_shapes

  ! Frequencies

  pure subroutine far_frequencies(k, beam, remainder, alpha, beta)
    !! Find β of known roots, which are refined in extended precision where needed.
    integer, intent(in) :: k(:)                  !! see `far_terms`
    type(far_beam), intent(in) :: beam
    real(dp), intent(in) :: remainder(:)         !! of the roots, δ
    type(dd), intent(inout) :: alpha(:)          !! the roots
    type(dd), intent(out) :: beta(:)
    logical :: coarse(size(k))
    coarse = is_coarse(remainder, alpha%hi, beam%omega, beam%longest)
    if (any(coarse)) call refine(k, beam, remainder, coarse, alpha)
    beta = alpha*alpha                           ! Eq. 3
    if (allocated(beam%omega)) call rotate(beam%omega, beta)
  end subroutine far_frequencies

  pure subroutine refine(k, beam, remainder, coarse, alpha)
    !! Refine coarse roots in extended precision.
    integer, intent(in) :: k(:)
    type(far_beam), intent(in) :: beam
    real(dp), intent(in) :: remainder(:)
    logical, intent(in) :: coarse(:)
    type(dd), intent(inout) :: alpha(:)
    type(root_type) :: root(size(k))
    root%k = k
    root%eighths = 4*k - merge(2, 3, light_modes(k(:1), beam%gamma%hi) == 1)
    root%remainder = remainder
    root%gamma = beam%gamma%hi
    root%gamma_low = beam%gamma%lo
    call refine_roots(root, coarse, alpha)
  end subroutine refine

  pure subroutine rotate(omega, beta)
    !! Convert α² to β: α⁴ − ω² without cancellation, Eq. 2.
    type(dd), intent(in) :: omega
    type(dd), intent(inout) :: beta(:)
    integer :: i
    beta = (beta - omega)*(beta + omega)
    if (all(beta%hi >= 0.0_dp)) then
      beta = sqrt(beta)
      return
    end if
    do i = 1, size(beta)
      if (beta(i)%hi >= 0.0_dp) then
        beta(i) = sqrt(beta(i))
      else
        beta(i) = -sqrt(-beta(i))
      end if
    end do
  end subroutine rotate

end module bw_far_modes
