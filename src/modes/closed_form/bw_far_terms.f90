module bw_far_terms
  !! What a sum over modes asks of far ones: β, the velocity that momentum at the tip gives, and the shapes at points.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, sqrt, operator(*), operator(+), operator(-)
  use bw_far_modes, only: far_roots, far_shapes, far_tip_and_drive
  use bw_frequency_equation, only: root_type
  use bw_refined_root, only: any_coarse, is_coarse, refine_roots
  implicit none (type, external)
  private
  public :: far_terms, far_shapes_and_roots, far_frequencies

contains

  pure subroutine far_terms(k, gamma, light, omega, xi, longest, beta, drive, shapes)
    !! Modes whose exponentials are below rounding (bw_far_modes), all light or all heavy; a few hundred at a time.
    integer, intent(in) :: k(:)                !! ascending
    type(dd), intent(in) :: gamma
    logical, intent(in) :: light
    type(dd), intent(in), optional :: omega    !! in-plane angular velocity in h/l²; absent: none acts on the modes
    real(dp), intent(in) :: xi(:)              !! ξ = 0 or αξ ≥ ½, (points)
    real(dp), intent(in), optional :: longest  !! as that of `is_coarse`
    type(dd), intent(out) :: beta(:)           !! √|β²| with the sign of β², (modes)
    real(dp), intent(out) :: drive(:)          !! Φ_k(1)/M_k, (modes)
    real(dp), intent(out) :: shapes(:, :)      !! Φ_k(ξ), (modes, points)
    real(dp) :: rest(size(k))
    type(dd) :: alpha(size(k))
    call far_shapes_and_roots(k, gamma%hi, light, xi, rest, alpha, drive, shapes)
    call far_frequencies(k, gamma, light, omega, longest, rest, alpha, beta)
  end subroutine far_terms

  pure subroutine far_shapes_and_roots(k, gamma, light, xi, rest, alpha, drive, shapes)
    !! What has nothing to do with the rotation of the beam.
    integer, intent(in) :: k(:)                !! as those of `far_terms`
    real(dp), intent(in) :: gamma
    logical, intent(in) :: light
    real(dp), intent(in) :: xi(:)
    real(dp), intent(out) :: rest(:)           !! of the roots, as `far_roots` gives it, (modes)
    type(dd), intent(out) :: alpha(:)          !! roots, (modes)
    real(dp), intent(out) :: drive(:)          !! Φ_k(1)/M_k, (modes)
    real(dp), intent(out) :: shapes(:, :)      !! Φ_k(ξ), (modes, points)
    real(dp), dimension(size(k)) :: eighths, tangent, spread, turned, tip
    integer :: p
    eighths = 4*k - merge(2, 3, light)
    call far_roots(k, gamma, light, rest, tangent, spread, turned)
    call far_tip_and_drive(k, tangent, spread, turned, tip, drive)
    alpha = dd_pi*(0.25_dp*eighths) + rest
    do p = 1, size(xi)
      call far_shapes(eighths, rest, alpha%hi, tip, xi(p), shapes(:, p))
    end do
  end subroutine far_shapes_and_roots

  pure subroutine far_frequencies(k, gamma, light, omega, longest, rest, roots, beta)
    !! β of roots that are known: in binary64 where no phases are asked for.
    integer, intent(in) :: k(:)                !! as those of `far_terms`
    type(dd), intent(in) :: gamma
    logical, intent(in) :: light
    type(dd), intent(in), optional :: omega
    real(dp), intent(in), optional :: longest
    real(dp), intent(in) :: rest(:)
    type(dd), intent(in) :: roots(:)
    type(dd), intent(out) :: beta(:)
    type(dd) :: alpha(size(k))
    if (.not. present(longest)) then
      beta%hi = coarse_frequencies(roots%hi, omega)
      beta%lo = 0.0_dp
      return
    end if
    alpha = roots
    call refine(k, gamma, light, rest, omega, longest, alpha)
    beta = alpha*alpha                                   ! Eq. 3
    if (present(omega)) call rotate(omega, beta)
  end subroutine far_frequencies

  pure function coarse_frequencies(alpha, omega) result(beta)
    !! √|α⁴ − ω²| with the sign of what is under the root, Eq. 2.
    real(dp), intent(in) :: alpha(:)
    type(dd), intent(in), optional :: omega
    real(dp) :: beta(size(alpha)), square
    integer :: i
    if (.not. present(omega)) then
      beta = alpha**2
      return
    end if
    do i = 1, size(alpha)
      square = (alpha(i)**2 - omega%hi)*(alpha(i)**2 + omega%hi)
      beta(i) = sign(sqrt(abs(square)), square)
    end do
  end function coarse_frequencies

  pure subroutine refine(k, gamma, light, rest, omega, longest, alpha)
    !! Solve again in extended precision what binary64 cannot carry.
    integer, intent(in) :: k(:)
    type(dd), intent(in) :: gamma
    logical, intent(in) :: light
    real(dp), intent(in) :: rest(:)
    type(dd), intent(in), optional :: omega
    real(dp), intent(in), optional :: longest
    type(dd), intent(inout) :: alpha(:)
    type(root_type) :: root(size(k))
    if (.not. any_coarse(rest, alpha%hi, omega, longest)) return
    root%k = k
    root%eighths = 4*k - merge(2, 3, light)
    root%rest = rest
    root%gamma = gamma%hi
    root%gamma_low = gamma%lo
    call refine_roots(root, is_coarse(rest, alpha%hi, omega, longest), alpha)
  end subroutine refine

  pure subroutine rotate(omega, beta)
    !! From α² to β: α⁴ − ω² without cancellation, Eq. 2.
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

end module bw_far_terms
