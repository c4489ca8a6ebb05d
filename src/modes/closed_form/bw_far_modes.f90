module bw_far_modes
  !! Modes so high that sech α and 1 − tanh α are below rounding, many at a time in vector registers: what a sum over modes
  !! asks of them is algebraic in the tangent of the root's remainder.
  !!
  !! With α = (k − ¾)π + δ the frequency equation is tan δ = 1/(1 + 2γα); for a light mass, γα ≲ 1, with
  !! α = (k − ½)π + δ it is tan δ = −γα/(1 + γα), which keeps the digits of a small δ. Then
  !! Φ(1) = −2√2 s sin ϑ, M/m_i = 1 + 2γ sin²ϑ, tan ϑ = 1/(1 + 2γα), s = −(−1)^k, and
  !! Φ(ξ) = √2 cos(αξ + π/4) − e^(−αξ) + ½Φ(1)e^(−α(1−ξ)).
  !!
  !! **Errors**: as those of bw_root_list and bw_shape. **Source**: Eqs 18–21 without their vanishing parts.
  use bw_kinds, only: dp
  use bw_double_double, only: rounder, two_products
  implicit none (type, external)
  private
  public :: far_roots, far_tip_and_drive, far_shapes

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: nothing = 45.0_dp       !! e^(−45) is below rounding beside what it is added to

contains

  pure subroutine far_roots(k, gamma, light, rest, tangent, spread, turned)
    !! δ of every root, and what `far_tip_and_drive` needs: with A = α − δ, tan ϑ = t₀/(1 + eδ), t₀ = 1/(1 + 2γA), e = 2γt₀.
    integer, intent(in) :: k(:)                  !! mode numbers
    real(dp), intent(in) :: gamma                !! mass ratio
    logical, intent(in) :: light                 !! all anchored at (k − ½)π, else all at (k − ¾)π
    real(dp), intent(out) :: rest(:)             !! δ
    real(dp), intent(out) :: tangent(:)          !! t₀
    real(dp), intent(out) :: spread(:)           !! e
    real(dp), intent(out) :: turned(:)           !! 1 + eδ
    real(dp), dimension(size(k)) :: anchor, start
    real(dp) :: lightness
    if (size(k) == 0) return                     ! where all are light γ may be 0
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
    call settle(start, tangent, spread, rest)
    turned = 1.0_dp + spread*rest
  end subroutine far_roots

  pure subroutine settle(start, tangent, spread, rest)
    !! δ + atan z = δ₀, z = e t₀δ/(1 + t₀² + eδ): the tangent at α against that at the anchor. With η = δ₀ − δ this is
    !! z = (a − bη)/(1 − cη); a, b and c are below 1/100, η below 1/300, and series in them end below rounding.
    real(dp), intent(in) :: start(:)             !! δ₀
    real(dp), intent(in) :: tangent(:), spread(:)
    real(dp), intent(out) :: rest(:)
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
      rest(i) = start(i) - eta
    end do
  end subroutine settle

  pure subroutine far_tip_and_drive(k, tangent, spread, turned, tip, drive)
    !! Φ(1), and Φ(1)/M: the modal velocity that a unit of momentum at the tip gives.
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: tangent(:), spread(:), turned(:)     !! of `far_roots`
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

  pure subroutine far_shapes(eighths, rest, alpha, tip, xi, values)
    !! Φ_k(ξ), ξ = 0 or αξ ≥ ½; the whole eighths of a turn are multiplied and reduced exactly.
    real(dp), intent(in) :: eighths(:)           !! whole numbers; α = eighths·π/4 + rest, ascending
    real(dp), intent(in) :: rest(:), alpha(:), tip(:)
    real(dp), intent(in) :: xi
    real(dp), intent(out) :: values(:)
    real(dp), dimension(size(rest)) :: whole, part
    if (xi == 0.0_dp .or. xi == 1.0_dp) then
      values = xi*tip
      return
    end if
    call two_products(eighths, xi, whole, part)
    whole = whole - 8.0_dp*((0.125_dp*whole + rounder) - rounder)
    part = 0.25_dp*pi*(whole + (1.0_dp + part)) + rest*xi
    values = sqrt(2.0_dp)*cos(part)
    if (alpha(1)*xi < nothing) values = values - exp(-min(alpha*xi, nothing))
    if (alpha(1)*(1.0_dp - xi) < nothing) values = values + 0.5_dp*tip*exp(-min(alpha*(1.0_dp - xi), nothing))
  end subroutine far_shapes

end module bw_far_modes
