module bw_root_list
  !! Roots of the frequency equation for many modes at a time, in vector registers: except for the first few modes its
  !! exponentials are below rounding (bw_far_modes).
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, operator(*), operator(+)
  use bw_far_modes, only: far_roots, light_modes
  use bw_frequency_equation, only: root_type, solve_root
  use bw_mode_set, only: batch
  implicit none (type, external)
  private
  public :: solve_roots, root_values, near_modes

  integer, parameter :: last_to_try = 300    ! at 240 all relevant exponentials have underflowed

contains

  pure function solve_roots(k, gamma) result(root)
    !! Return `solve_root` of a list, in vector registers if exponentials are below rounding.
    integer, intent(in) :: k(:)      !! 1 … `highest_mode`, ascending
    real(dp), intent(in) :: gamma
    type(root_type) :: root(size(k))
    integer :: near
    near = near_modes(k, gamma)
    root(:near) = solve_root(k(:near), gamma)
    call solve_far_roots(k(near + 1:), gamma, root(near + 1:))
  end function solve_roots

  pure integer function near_modes(k, gamma) result(near)
    !! Count the modes of a list that are not far ones.
    integer, intent(in) :: k(:)      !! ascending
    real(dp), intent(in) :: gamma
    near = 0
    if (size(k) == 0) return
    if (k(1) <= last_to_try) near = count(k < first_far_mode(gamma))
  end function near_modes

  pure integer function first_far_mode(gamma) result(k)
    !! Return the first mode for which sech α and 1 − tanh α are below rounding relative to γα, if that is below 1, and
    !! 1/(γα), if that is.
    real(dp), intent(in) :: gamma
    real(dp), parameter :: margin = log(16.0_dp/epsilon(1.0_dp))
    real(dp) :: alpha, logarithm
    do k = 2, last_to_try
      alpha = (k - 0.75_dp)*pi
      logarithm = log(max(gamma, tiny(gamma))) + log(alpha)
      if (alpha > margin - min(0.0_dp, logarithm) .and. 2.0_dp*alpha > margin + max(0.0_dp, logarithm)) return
    end do
  end function first_far_mode

  pure subroutine solve_far_roots(k, gamma, root)
    !! Solve for roots of far modes, those of a light mass first.
    integer, intent(in) :: k(:)
    real(dp), intent(in) :: gamma
    type(root_type), intent(out) :: root(:)
    real(dp), dimension(size(k)) :: remainder, tangent, spread, turned
    integer :: n
    n = light_modes(k, gamma)
    call far_roots(k(:n), gamma, .true., remainder(:n), tangent(:n), spread(:n), turned(:n))
    call far_roots(k(n + 1:), gamma, .false., remainder(n + 1:), tangent(n + 1:), spread(n + 1:), turned(n + 1:))
    root%k = k
    root(:n)%eighths = 4*k(:n) - 2
    root(n + 1:)%eighths = 4*k(n + 1:) - 3
    root%remainder = remainder
    root%gamma = gamma
  end subroutine solve_far_roots

  pure function root_values(root) result(alpha)
    !! Return `root_value` of a list, in vector registers.
    type(root_type), intent(in) :: root(:)
    type(dd) :: alpha(size(root))
    alpha = dd_pi*(0.25_dp*root%eighths) + root%remainder
  end function root_values

end module bw_root_list
