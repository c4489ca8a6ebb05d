module bw_rayleigh
  !! Rayleigh's quotient of the modes of a strain system, part by part: β² = λ + what rotation adds, λ the elastic stiffness, of
  !! modes of mass 1.
  !!
  !! The quotient is wrong by the square of what a shape is wrong. It says β² where (β² + σ)^(−½) leaves it as a small
  !! difference, and where two ways to the same number agree there are digits.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_strain_basis, only: integral, times_quadratic
  use bw_strain_modes, only: strain_modes
  implicit none (type, external)
  private
  public :: elastic_part, rotation_part

contains

  pure function elastic_part(modes) result(part)
    !! λ = K_kk, (modes).
    type(strain_modes), intent(in) :: modes
    real(dp) :: part(size(modes%period))
    part = sum(modes%strain**2, dim=1)
  end function elastic_part

  pure function rotation_part(operator, modes) result(part)
    !! β² − λ, (modes): the work against the tension, less Ω² times what of the mass the centrifugal force acts on.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    real(dp) :: part(size(modes%period))
    integer :: k
    part = 0.0_dp
    if (.not. allocated(operator%omega)) return
    do k = 1, size(part)
      if (operator%in_plane) then
        part(k) = part_in_plane(operator, modes, k)
      else
        part(k) = part_out_of_plane(operator, modes, k)
      end if
    end do
  end function rotation_part

  pure real(dp) function part_in_plane(operator, modes, k) result(part)
    !! ∫Tv'² − Ω²(∫v² + γv(1)²). Of the tension the body's own share is Ω²γ(1 + R), and since v(1) is the mean of v',
    !! γ((1 + R)∫v'² − v(1)²) = γ(R∫v'² + ∫(v' − v(1))²), in which nothing cancels however heavy it is.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    integer, intent(in) :: k
    real(dp) :: slope(modes%system%functions + 1), square, pull
    square = operator%omega%hi**2
    part = -square*sum(modes%motion(:modes%system%functions + 2, k)**2)
    if (allocated(operator%tension)) then
      slope = slope_of(operator, modes%strain(:, k))
      pull = -operator%tension(2)                          ! Ω²R
      part = part + dot_product(slope, times_quadratic([0.5_dp*square + pull, operator%tension(2:)], slope))
      part = part + operator%gamma*(pull*sum(slope**2) + square*sum(slope(2:)**2))
    else if (modes%system%tip_row > 0) then
      part = part - square*modes%motion(modes%system%tip_row, k)**2
    end if
  end function part_in_plane

  pure real(dp) function part_out_of_plane(operator, modes, k) result(part)
    !! ∫Tv'² − Ω²r²∫ψ²; a body's rotary inertia has no part.
    type(beam_operator), intent(in) :: operator
    type(strain_modes), intent(in) :: modes
    integer, intent(in) :: k
    real(dp) :: slope(modes%system%functions + 1)
    part = 0.0_dp
    associate (row => modes%system%turn_row, n => modes%system%functions)
      if (row > 0) part = -operator%omega%hi**2*sum(modes%motion(row:row + n, k)**2)
    end associate
    if (.not. allocated(operator%tension)) return
    slope = slope_of(operator, modes%strain(:, k))
    part = part + dot_product(slope, times_quadratic(operator%tension, slope))
  end function part_out_of_plane

  pure function slope_of(operator, strain) result(slope)
    !! Coefficients of v' = ψ and the shear strain.
    type(beam_operator), intent(in) :: operator
    real(dp), intent(in) :: strain(:)                      !! curvature, and shear strain over s
    real(dp), allocatable :: slope(:)
    integer :: n
    n = size(strain)
    if (allocated(operator%shear)) n = n/2
    slope = integral(strain(:n))
    if (allocated(operator%shear)) slope(:n) = slope(:n) + sqrt(operator%shear%compliance)*strain(n + 1:)
  end function slope_of

end module bw_rayleigh
