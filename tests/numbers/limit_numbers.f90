module limit_numbers
  !! Limits whose answer is known: no mass, an endless mass, no rotation, an elastic blow.
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_frequency_equation, only: solve_root
  use bw_impact, only: impact_type, strike
  use bw_kinds, only: dp, qp
  use bw_response, only: response_type
  use bw_shape, only: shape_of, shape_type, shape_value
  use number_table, only: table_type
  use paper_motion, only: catch_mass, catch_type, paper_beam
  use reference_table, only: column
  implicit none (type, external)
  private
  public :: measure_limits

  real(dp), parameter :: bound = 1.0e-14_dp
  real(dp), parameter :: nearly_nothing = 1.0e-300_dp

contains

  subroutine measure_limits(table)
    type(table_type), intent(inout) :: table
    call light_mass(table)
    call heavy_mass(table)
    call slow_rotation(table)
    call elastic_blow(table)
    call momentum_of_blows(table)
  end subroutine measure_limits

  subroutine light_mass(table)
    !! α, Φ(1), M and the shape itself at γ = 1e-300 against γ = 0.
    type(table_type), intent(inout) :: table
    type(shape_type) :: light
    real(qp), allocatable :: gamma(:), k(:), alpha(:), xi(:), value(:)
    integer :: i
    call table%begin('γ → 0 is the free beam', bound, 'relative; shapes absolute')
    gamma = column('roots.txt', 'gamma')
    k = column('roots.txt', 'k')
    alpha = column('roots.txt', 'alpha')
    do i = 1, size(k)
      if (gamma(i) > 0) cycle
      light = shape_of(solve_root(nint(k(i)), nearly_nothing))
      call table%note([real(abs(light%alpha/alpha(i) - 1), dp), abs(0.5_dp*abs(light%tip) - 1), abs(light%modal_mass - 1)])
    end do
    gamma = column('shapes.txt', 'gamma')
    k = column('shapes.txt', 'k')
    xi = column('shapes.txt', 'xi')
    value = column('shapes.txt', 'shape')
    do i = 1, size(k)
      if (gamma(i) > 0) cycle
      light = shape_of(solve_root(nint(k(i)), nearly_nothing))
      call table%note(real(abs(shape_value(light, real(xi(i), dp)) - value(i)), dp))
    end do
  end subroutine light_mass

  subroutine heavy_mass(table)
    !! α_(k+1) is root k of tan α = tanh α, and γα₁⁴ = 3.
    type(table_type), intent(inout) :: table
    type(shape_type), allocatable :: heavy(:)
    type(shape_type) :: first
    real(dp), parameter :: endless = 1.0e300_dp
    call table%begin('γ → ∞ is clamped–pinned, with γα₁⁴ = 3', bound, 'relative; tip absolute')
    heavy = shape_of(solve_root(nint(column('clamped_pinned.txt', 'k')) + 1, endless))
    call table%note(real(abs(heavy%alpha/column('clamped_pinned.txt', 'alpha') - 1), dp))
    call table%note(abs(heavy%tip))
    first = shape_of(solve_root(1, endless))
    call table%note(abs(endless*first%alpha**4/3 - 1))
  end subroutine heavy_mass

  subroutine slow_rotation(table)
    type(table_type), intent(inout) :: table
    type(response_type) :: still, turning
    real(dp), parameter :: slow(3) = [1.0e-300_dp, 1.0e-30_dp, 1.0e-9_dp]   ! rad/s
    real(dp), parameter :: points(3) = [0.1_dp, 0.5_dp, 1.0_dp]
    integer :: i, p
    call table%begin('ω → 0 is continuous, histories to 1 s', bound, 'part of the peak')
    call catch_mass(paper_beam(), catch_type(modes=20, samples=1000), points, .true., still)
    do i = 1, size(slow)
      call catch_mass(paper_beam(), catch_type(omega=slow(i), modes=20, samples=1000), points, .true., turning)
      do p = 1, size(points)
        call table%note(abs(turning%displacement(:, p) - still%displacement(:, p))/maxval(abs(still%displacement(:, p))))
        call table%note(abs(turning%velocity(:, p) - still%velocity(:, p))/maxval(abs(still%velocity(:, p))))
      end do
    end do
  end subroutine slow_rotation

  subroutine elastic_blow(table)
    type(table_type), intent(inout) :: table
    type(impact_type) :: impact
    integer :: n, power
    call table%begin('e = 1 keeps kinetic energy, 1 to 10⁴ modes, γ = 1e-12 … 1e12', bound, 'relative')
    do n = 0, 4
      do power = -12, 12
        impact = strike(closed_form_modes(10**n, 0.0_dp), 10.0_dp**power, 1.0_dp)
        call table%note(abs(impact%event%energy_after/impact%event%energy_before - 1))
      end do
    end do
  end subroutine elastic_blow

  subroutine momentum_of_blows(table)
    !! M_iΔq̇_i + m_jφ_i(1)Δv_j = 0 for each mode, over the momentum that the mass brings.
    type(table_type), intent(inout) :: table
    type(closed_form_set) :: modes
    type(impact_type) :: impact
    integer :: n, power, tenths
    call table%begin('any e keeps generalised momentum, 1 to 10⁴ modes, γ = 1e-12 … 1e12', bound, 'relative')
    do n = 0, 4
      modes = closed_form_modes(10**n, 0.0_dp)
      do power = -12, 12
        do tenths = 0, 10, 2
          impact = strike(modes, 10.0_dp**power, 0.1_dp*tenths)
          call table%note(abs(modes%modal_mass*impact%modal_velocity/modes%struck/impact%gamma + (impact%mass_velocity - 1)))
          call table%note(abs(impact%event%momentum_after/impact%event%momentum_before - 1))
        end do
      end do
    end do
  end subroutine momentum_of_blows

end module limit_numbers
