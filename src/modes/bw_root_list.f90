module bw_root_list
  !! Roots of the frequency equation for many modes at a time, in vector registers: beyond the first few modes its
  !! exponentials are below rounding, and a fixed number of steps solves what is left.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, operator(*), operator(+)
  use bw_frequency_equation, only: root_type, solve_root
  implicit none (type, external)
  private
  public :: solve_roots, root_values

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: far_steps = 2        !! of Newton's method

contains

  pure function solve_roots(k, gamma) result(root)
    !! `solve_root` of a list, in vector registers where the exponentials are below rounding.
    integer, intent(in) :: k(:)      !! 1 … `highest_mode`, ascending
    real(dp), intent(in) :: gamma
    type(root_type) :: root(size(k))
    integer :: near
    near = count(k < first_far_mode(gamma))
    root(:near) = solve_root(k(:near), gamma)
    call solve_far_roots(k(near + 1:), gamma, root(near + 1:))
  end function solve_roots

  pure integer function first_far_mode(gamma) result(k)
    !! From this mode on sech α and 1 − tanh α are below rounding of what they are added to: γα, where it is below 1,
    !! and 1/(γα), where that is.
    real(dp), intent(in) :: gamma
    real(dp), parameter :: margin = log(16.0_dp/epsilon(1.0_dp))
    real(dp) :: alpha, logarithm
    do k = 2, 300      ! at 240 all there is to lose has underflowed
      alpha = (k - 0.75_dp)*pi
      logarithm = log(max(gamma, tiny(gamma))) + log(alpha)
      if (alpha > margin - min(0.0_dp, logarithm) .and. 2.0_dp*alpha > margin + max(0.0_dp, logarithm)) return
    end do
  end function first_far_mode

  pure subroutine solve_far_roots(k, gamma, root)
    !! a sin δ + b cos δ = 0, `light_equation` and `heavy_equation` without their exponentials. The second derivative is
    !! next to zero where the function is, so Newton's error falls from 3e-3 to 1e-7 and below rounding.
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: gamma
    type(root_type), intent(out) :: root(:)
    real(dp), dimension(size(k)) :: anchor, delta, alpha, a, b, change, c, s
    logical :: light(size(k))
    integer :: i
    light = gamma <= 1.0_dp/((k - 0.75_dp)*pi)
    anchor = (k - merge(0.5_dp, 0.75_dp, light))*pi
    call coefficients(anchor, gamma, light, a, b)
    delta = -b/(a + 0.32_dp*b**2/a)            ! near the arc tangent of −b/a, which is at most ½
    do i = 1, far_steps
      alpha = anchor + delta
      call coefficients(alpha, gamma, light, a, b)
      change = b/alpha                         ! da/dα, and db/dα but for the sign
      c = cos(delta)
      s = sin(delta)
      delta = delta - (a*s + b*c)/(a*c - b*s + change*s + merge(change, -change, light)*c)
    end do
    root%k = k
    root%eighths = merge(4*k - 2, 4*k - 3, light)
    root%rest = delta
    root%gamma = gamma
  end subroutine solve_far_roots

  pure subroutine coefficients(alpha, gamma, light, a, b)
    !! a = 1 + γα and b = γα at the anchor of a light mass; a = 2 + u and b = −u, u = 1/(γα), at that of a heavy one.
    real(dp), intent(in) :: alpha(:), gamma
    logical, intent(in) :: light(:)
    real(dp), intent(out) :: a(:), b(:)
    b = merge(alpha*min(gamma, 1.0_dp), -1.0_dp/alpha/max(gamma, tiny(gamma)), light)
    a = merge(1.0_dp, 2.0_dp, light) + abs(b)
  end subroutine coefficients

  pure function root_values(root) result(alpha)
    !! `root_value` of a list, in vector registers.
    type(root_type), intent(in) :: root(:)
    type(dd) :: alpha(size(root))
    alpha = dd_pi*(0.25_dp*root%eighths) + root%rest
  end function root_values

end module bw_root_list
