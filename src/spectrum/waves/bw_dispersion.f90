module bw_dispersion
  !! The dispersion of measured pairs of frequency and wave number, β² = h² k⁴ − ω² with h = √(EI/ρA) (Eq. 3): k = q (β² + ω²)^¼,
  !! q = h^(−½), fitted to the wave numbers weighted by their variances; and the group velocity dβ/dk on that curve.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: fit_dispersion, group_velocity_of

  integer, parameter :: most_rounds = 50

  type, public :: dispersion_type
    !! The fitted curve; `exists` is false where there is none.
    logical :: exists = .false.
    real(dp) :: q = 0, turning = 0             !! q and ω², 0 without rotation, in units of the arguments
    real(dp) :: covariance(2, 2) = 0           !! of q and ω²
    real(dp) :: misfit = 0                     !! sum of squared residuals over their variances
    integer :: freedom = 0
  end type dispersion_type

contains

  pure type(dispersion_type) function fit_dispersion(square, wavenumber, variance, rotates) result(curve)
    !! Fit by weighted least squares (Gauss–Newton). One pair is enough, or two if the beam rotates.
    real(dp), intent(in) :: square(:)          !! β² of the undamped lines, (line)
    real(dp), intent(in) :: wavenumber(:)
    real(dp), intent(in) :: variance(:)        !! of wave numbers, including the effect of the frequencies' errors
    logical, intent(in) :: rotates             !! in the plane of bending, so that ω is fitted
    real(dp), dimension(size(square)) :: root, by_q, by_turning, residual
    real(dp) :: normal(2, 2), determinant, move(2), line(2)
    integer :: i
    curve%freedom = size(square) - merge(2, 1, rotates)
    if (curve%freedom < 0) return
    if (rotates) then
      line = straight(square, wavenumber**4, 16*wavenumber**6*variance)
      if (.not. line(1) > 0) return
      curve%turning = line(2)/line(1)
    end if
    do i = 1, most_rounds
      if (any(square + curve%turning <= 0)) return
      root = (square + curve%turning)**0.25_dp
      curve%q = sum(wavenumber*root/variance)/sum(root**2/variance)
      residual = wavenumber - curve%q*root
      by_q = root
      by_turning = curve%q*root/(4*(square + curve%turning))
      normal = reshape([sum(by_q**2/variance), sum(by_q*by_turning/variance), &
        & sum(by_q*by_turning/variance), sum(by_turning**2/variance)], [2, 2])
      if (.not. rotates) exit
      determinant = normal(1, 1)*normal(2, 2) - normal(1, 2)**2
      if (.not. determinant > 0) return
      move = [sum(by_q*residual/variance), sum(by_turning*residual/variance)]
      move(2) = (normal(1, 1)*move(2) - normal(1, 2)*move(1))/determinant
      curve%turning = curve%turning + max(move(2), -(minval(square) + curve%turning)/2)
      if (abs(move(2)) <= 4*epsilon(1.0_dp)*maxval(square)) exit
    end do
    curve%misfit = sum(residual**2/variance)
    if (rotates) then
      curve%covariance = reshape([normal(2, 2), -normal(1, 2), -normal(1, 2), normal(1, 1)], [2, 2])/determinant
    else
      curve%covariance(1, 1) = 1/normal(1, 1)
    end if
    curve%exists = .true.
  end function fit_dispersion

  pure function straight(x, y, variance) result(line)
    !! Slope and intercept of the weighted straight line through points.
    real(dp), intent(in) :: x(:), y(:), variance(:)
    real(dp) :: line(2), middle
    middle = sum(x/variance)/sum(1/variance)
    line(1) = sum((x - middle)*y/variance)/sum((x - middle)**2/variance)
    line(2) = sum(y/variance)/sum(1/variance) - line(1)*middle
  end function straight

  elemental subroutine group_velocity_of(curve, square, square_deviation, velocity, deviation)
    !! The group velocity 2h²k³/β at k on the curve, 2(β² + ω²)^¾/(qβ), and its standard deviation.
    type(dispersion_type), intent(in) :: curve
    real(dp), intent(in) :: square, square_deviation  !! β² and its standard deviation
    real(dp), intent(out) :: velocity, deviation
    real(dp) :: slope(2)
    velocity = 2*(square + curve%turning)**0.75_dp/(curve%q*sqrt(square))
    slope = [-1/curve%q, 0.75_dp/(square + curve%turning)]
    deviation = velocity*sqrt(dot_product(slope, matmul(curve%covariance, slope)) &
      & + (square_deviation*(0.75_dp/(square + curve%turning) - 0.5_dp/square))**2)
  end subroutine group_velocity_of

end module bw_dispersion
