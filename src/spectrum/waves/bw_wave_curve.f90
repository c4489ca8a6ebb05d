module bw_wave_curve
  !! The curve α⁴ = A β² + B of a uniform beam through candidate wave numbers (recursive least squares), A > 0 and B ≥ 0, with
  !! B = 0 without rotation (Eq. 3); the mean of the tip masses that they imply; and its cost, the sum of squared distances in
  !! standard deviations.
  use bw_kinds, only: dp
  use bw_shape_fit, only: worse
  use bw_wave_candidates, only: problem_type
  implicit none (type, external)
  private
  public :: curve_through, distance_cost, is_curve, mass_cost, predicted_variance, take

  type, public :: curve_type
    !! α⁴ = sum(value·[β², 1]) with its covariance, and the mean of the masses so far.
    real(dp) :: value(2) = 0, covariance(2, 2) = 0
    real(dp) :: angle = 0, angle_variance = huge(1.0_dp)
    real(dp) :: cost = 0
  end type curve_type

contains

  pure logical function is_curve(curve)
    !! Whether the curve is that of a beam: A > 0 and, within five standard deviations, B ≥ 0.
    type(curve_type), intent(in) :: curve
    is_curve = curve%value(1) > 0 .and. curve%value(2) >= -sqrt(worse*curve%covariance(2, 2)) &
      & .and. curve%cost < huge(1.0_dp)/8
  end function is_curve

  pure type(curve_type) function curve_through(problem, lines, own) result(curve)
    !! The curve through one candidate and the origin, or through two candidates.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: lines(:), own(:)
    real(dp) :: slope(2, 2), far
    integer :: i
    if (size(lines) == 1) then
      curve%value(1) = problem%power(own(1), lines(1))/problem%square(lines(1))
      curve%covariance(1, 1) = problem%variance(own(1), lines(1))/problem%square(lines(1))**2
    else
      far = problem%square(lines(2)) - problem%square(lines(1))
      slope(1, :) = [-1.0_dp, 1.0_dp]/far
      slope(2, :) = [problem%square(lines(2)), -problem%square(lines(1))]/far
      do i = 1, 2
        curve%value = curve%value + slope(:, i)*problem%power(own(i), lines(i))
        curve%covariance = curve%covariance + problem%variance(own(i), lines(i))*spread(slope(:, i), 2, 2)*spread(slope(:, i), 1, 2)
      end do
    end if
    do i = 1, size(lines)
      curve%cost = curve%cost + problem%cost(own(i), lines(i))
      if (problem%tip) call add_mass(problem, own(i), lines(i), curve)
    end do
    if (size(lines) == 1) return
    if (problem%tip .and. problem%mode(own(1), lines(1)) == problem%mode(own(size(own)), lines(size(lines)))) &
      & curve%cost = huge(1.0_dp)/4
  end function curve_through

  pure subroutine add_mass(problem, own, line, curve)
    !! Add the mass that a candidate implies to the mean, and its squared distance from the mean to the cost.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(inout) :: curve
    real(dp) :: share
    curve%cost = curve%cost + mass_cost(problem, own, line, curve)
    share = 1
    if (curve%angle_variance < huge(1.0_dp)) share = curve%angle_variance/(curve%angle_variance + problem%angle_variance(own, line))
    curve%angle = curve%angle + share*(problem%angle(own, line) - curve%angle)
    curve%angle_variance = share*problem%angle_variance(own, line)
  end subroutine add_mass

  pure real(dp) function mass_cost(problem, own, line, curve)
    !! Cost of a candidate that implies another mass; at most half the cost of a line that is on no curve.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(in) :: curve
    mass_cost = 0
    if (.not. problem%tip .or. .not. curve%angle_variance < huge(1.0_dp)) return
    mass_cost = min(worse/2, (problem%angle(own, line) - curve%angle)**2/ &
      & (curve%angle_variance + problem%angle_variance(own, line) + tiny(1.0_dp)))
  end function mass_cost

  pure real(dp) function predicted_variance(problem, line, curve) result(variance)
    !! Variance of the curve's α⁴ at a line.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: line
    type(curve_type), intent(in) :: curve
    variance = max(0.0_dp, dot_product([problem%square(line), 1.0_dp], matmul(curve%covariance, [problem%square(line), 1.0_dp])))
  end function predicted_variance

  pure real(dp) function distance_cost(problem, own, line, curve)
    !! Squared distance of a candidate from the curve, over its variance.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(in) :: curve
    distance_cost = (problem%power(own, line) - dot_product(curve%value, [problem%square(line), 1.0_dp]))**2/ &
      & (problem%variance(own, line) + predicted_variance(problem, line, curve))
  end function distance_cost

  pure subroutine take(problem, own, line, curve)
    !! Add a candidate to the curve.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(inout) :: curve
    real(dp) :: gain(2), reduction(2, 2), variance
    variance = problem%variance(own, line) + predicted_variance(problem, line, curve)
    gain = matmul(curve%covariance, [problem%square(line), 1.0_dp])/variance
    curve%cost = curve%cost + problem%cost(own, line) + distance_cost(problem, own, line, curve)
    curve%value = curve%value + gain*(problem%power(own, line) - dot_product(curve%value, [problem%square(line), 1.0_dp]))
    reduction = -spread(gain, 2, 2)*spread([problem%square(line), 1.0_dp], 1, 2)
    reduction(1, 1) = reduction(1, 1) + 1
    reduction(2, 2) = reduction(2, 2) + 1
    curve%covariance = matmul(matmul(reduction, curve%covariance), transpose(reduction)) &
      & + problem%variance(own, line)*spread(gain, 2, 2)*spread(gain, 1, 2)  ! Joseph's form, which stays positive definite
    if (problem%tip) call add_mass(problem, own, line, curve)
  end subroutine take

end module bw_wave_curve
