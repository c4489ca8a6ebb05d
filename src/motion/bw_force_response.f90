module bw_force_response
  !! What a force that is a polynomial in time does to an oscillator that is at rest: q̈ + cq̇ + β²q = (t/h)^j, exactly.
  !!
  !! With s₁, s₂ the roots of s² + cs + β² the displacement at t = h is h(I_j(s₁h) − I_j(s₂h))/(s₁ − s₂), where
  !! I_j(z) = ∫₀¹ e^(z(1−w))w^j dw. Its recurrence I_j = (j I_(j−1) − 1)/z is stable forwards for large |z| and backwards for small. Where
  !! both |s|h are small the roots would cancel: there the motion is its power series. Without dimensions.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: find_force_response

  integer, parameter, public :: force_degree = 6   !! of a force in a step
  real(dp), parameter :: slow = 1.0_dp             !! |s|h below which the power series is taken
  real(dp), parameter :: apart = 1.0e-5_dp         !! of c/2, by which the roots of a mode at its critical damping are taken apart

contains

  pure subroutine find_force_response(beta_squared, c, time, displacement, velocity)
    !! At the end of a time h, for each power j. **Limit**: e^(s₁h) must not overflow.
    real(dp), intent(in) :: beta_squared, c
    real(dp), intent(in) :: time                   !! h > 0
    real(dp), intent(out) :: displacement(0:force_degree), velocity(0:force_degree)
    complex(dp) :: root, s(2), first(0:force_degree), second(0:force_degree)
    real(dp) :: half
    if (max(sqrt(abs(beta_squared)), c)*time < slow) then
      call sum_series(beta_squared*time**2, c*time, displacement, velocity)
      displacement = displacement*time**2
      velocity = velocity*time
      return
    end if
    half = 0.5_dp*c
    root = sqrt(cmplx(half**2 - beta_squared, 0.0_dp, dp))
    if (abs(root) < apart*half) root = apart*half
    s = [-half + root, -half - root]
    if (half > 0.0_dp .and. abs(aimag(root)) == 0.0_dp .and. abs(s(2)) > 0.0_dp) s(1) = beta_squared/s(2)
    first = kernel_moments(s(1)*time)
    if (abs(aimag(root)) > 0.0_dp) then            ! the other root is the conjugate
      displacement = time*aimag(first)/aimag(root)
      velocity = time*aimag(s(1)*first)/aimag(root)
    else
      second = kernel_moments(s(2)*time)
      displacement = time*real((first - second)/(2.0_dp*root))
      velocity = time*real((s(1)*first - s(2)*second)/(2.0_dp*root))
    end if
  end subroutine find_force_response

  pure function kernel_moments(z) result(moment)
    !! I_0 … I_n.
    complex(dp), intent(in) :: z
    complex(dp) :: moment(0:force_degree)
    real(dp), parameter :: large = force_degree    ! |z| from which the recurrence is stable forwards
    integer, parameter :: terms = 34               ! 6^m 6!/(m + 7)! is below rounding then
    complex(dp) :: term
    integer :: j, m
    if (abs(z) >= large) then
      moment(0) = (exp(z) - 1.0_dp)/z
      do j = 1, force_degree
        moment(j) = (j*moment(j - 1) - 1.0_dp)/z
      end do
      return
    end if
    term = 1.0_dp/(force_degree + 1)
    moment(force_degree) = term
    do m = 1, terms
      term = term*z/(force_degree + 1 + m)
      moment(force_degree) = moment(force_degree) + term
    end do
    do j = force_degree, 1, -1
      moment(j - 1) = (1.0_dp + z*moment(j))/j
    end do
  end function kernel_moments

  pure subroutine sum_series(square, damping, displacement, velocity)
    !! y″ + Cy′ + By = u^j at u = 1, from rest at u = 0.
    real(dp), intent(in) :: square, damping        !! B and C, at most 1
    real(dp), intent(out) :: displacement(0:force_degree), velocity(0:force_degree)
    integer, parameter :: terms = 22
    real(dp) :: before, coefficient, next
    integer :: j, m
    do j = 0, force_degree
      before = 0.0_dp
      coefficient = 1.0_dp/((j + 1)*(j + 2))
      displacement(j) = coefficient
      velocity(j) = (j + 2)*coefficient
      do m = j + 3, j + 2 + terms
        next = -(damping*(m - 1)*coefficient + square*before)/(m*(m - 1))
        before = coefficient
        coefficient = next
        displacement(j) = displacement(j) + coefficient
        velocity(j) = velocity(j) + m*coefficient
      end do
    end do
  end subroutine sum_series

end module bw_force_response
