module bw_strain_modes
  !! Modes of a strain system by their singular values, in as many functions as they need.
  !!
  !! **Errors**: β² + σ within 1e-13 relatively for 200 modes, Ω from 0 to 1000 and every slenderness (tests).
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_lapack, only: dpotrf, dtrsm
  use bw_mode_demand, only: mode_demand
  use bw_monitor, only: monitor_type, stops
  use bw_singular_values, only: singular_values
  use bw_strain_system, only: build_system, strain_system
  implicit none (type, external)
  private
  public :: solve_strain_modes, solve_with, solve_system

  integer, parameter :: watched = 4                !! how many of the last: neighbours may vanish by parity
  integer, parameter :: most_functions = 2000

  type, public :: strain_modes
    !! The first modes, each with BᵀB-norm 1.
    type(strain_system) :: system                  !! without its matrices
    real(dp), allocatable :: period(:)             !! (β² + σ)^(−½), descending, (modes)
    real(dp), allocatable :: motion(:, :)          !! rows of B: coefficients of v, rψ, √γ v(1), √J ψ(1), (rows, modes)
    real(dp), allocatable :: strain(:, :)          !! curvatures, and shear strains over s, (unknowns, modes)
    logical :: resolved = .false.                  !! the functions were enough
  end type strain_modes

contains

  subroutine solve_strain_modes(operator, count, modes, monitor, demand)
    !! Find the first `count` modes; not `resolved`, and maybe without arrays, where there are none to be had.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count                   !! ≥ 1
    type(strain_modes), intent(out) :: modes
    class(monitor_type), intent(inout), optional :: monitor    !! none are found where it asks to stop
    type(mode_demand), intent(in), optional :: demand
    type(mode_demand) :: wanted
    integer :: functions
    if (present(demand)) wanted = demand
    functions = first_guess(operator, count, wanted)
    if (functions > most_functions) return
    do
      call solve_with(operator, count, functions, modes, monitor)
      if (stops(monitor)) return
      if (modes%resolved) modes%resolved = all(last_coefficients(modes) < wanted%negligible())
      if (modes%resolved .or. functions == most_functions) exit
      functions = min(functions + functions/2, most_functions)
    end do
  end subroutine solve_strain_modes

  pure integer function first_guess(operator, count, wanted)
    !! How many functions to try first. Half a wave of mode k needs π/2 polynomials, and the ends need more. Tension leaves bending
    !! to a layer at the clamp of length δ = √((1 + s²T)/T), which needs about 4/√δ.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    type(mode_demand), intent(in) :: wanted
    real(dp), parameter :: layer = 2.5_dp          ! tuned: what is never enough
    real(dp) :: pull
    first_guess = wanted%ends(30) + count + (3*count)/4    ! tuned
    if (.not. allocated(operator%tension)) return
    pull = operator%tension(1)
    if (allocated(operator%shear)) pull = pull/(1.0_dp + operator%shear%compliance*pull)
    first_guess = max(first_guess, int(min(layer*sqrt(sqrt(pull)), 2.0_dp*most_functions)))
  end function first_guess

  subroutine solve_with(operator, count, functions, modes, monitor)
    !! Find modes in a given number of functions; `resolved` says no more than that LAPACK had no trouble.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    integer, intent(in) :: functions               !! ≥ `count` and 3
    type(strain_modes), intent(out) :: modes
    class(monitor_type), intent(inout), optional :: monitor
    call build_system(operator, functions, modes%system)
    call solve_system(count, modes, monitor)
  end subroutine solve_with

  subroutine solve_system(count, modes, monitor)
    !! Find modes of a system that is built; `resolved` says no more than that LAPACK had no trouble.
    integer, intent(in) :: count                   !! ≤ unknowns
    type(strain_modes), intent(inout) :: modes     !! of which there is a system
    class(monitor_type), intent(inout), optional :: monitor
    integer :: info
    associate (s => modes%system%stiffness, b => modes%system%mass_root)
      call dpotrf('L', size(s, 1), s, size(s, 1), info)
      if (info == 0) call divide_by_factor(s, b, monitor)
    end associate
    if (stops(monitor)) return
    if (info == 0) call singular_values(modes%system%mass_root, count, modes%period, modes%motion, modes%strain, info, monitor)
    modes%resolved = info == 0
    if (stops(monitor)) modes%resolved = .false.
    if (modes%resolved) modes%resolved = all(modes%period > 0.0_dp)
    if (modes%resolved) call find_strains(modes)
    deallocate (modes%system%stiffness, modes%system%mass_root)
  end subroutine solve_system

  subroutine find_strains(modes)
    !! Find the unknowns x = L⁻ᵀ(right singular vector)/value, and from them the strains.
    type(strain_modes), intent(inout) :: modes
    integer :: k
    associate (s => modes%system%stiffness, x => modes%strain)
      call dtrsm('L', 'L', 'T', 'N', size(x, 1), size(x, 2), 1.0_dp, s, size(s, 1), x, size(x, 1))
      do k = 1, size(x, 2)
        x(:, k) = x(:, k)/modes%period(k)
      end do
      if (modes%system%tip_row > 0) call sharpen_tip(modes)
      if (allocated(modes%system%tip)) call modes%system%tip%from_rows(x)
    end associate
  end subroutine find_strains

  subroutine divide_by_factor(s, b, monitor)
    !! Replace B by B L⁻ᵀ, a batch of rows at a time.
    real(dp), intent(in) :: s(:, :)
    real(dp), intent(inout) :: b(:, :)
    class(monitor_type), intent(inout), optional :: monitor
    integer, parameter :: batch = 512
    integer :: first, last
    do first = 1, size(b, 1), batch
      if (stops(monitor)) return
      last = min(first + batch - 1, size(b, 1))
      call dtrsm('R', 'L', 'T', 'N', last - first + 1, size(b, 2), 1.0_dp, s, size(s, 1), b(first:last, :), last - first + 1)
    end do
  end subroutine divide_by_factor

  pure subroutine sharpen_tip(modes)
    !! Find √γ v(1) of a heavy mass that hardly moves from the force on it: the row of v(1) in S x = p⁻²M x.
    type(strain_modes), intent(inout) :: modes
    real(dp) :: force, push, rounding
    integer :: k
    associate (system => modes%system, x => modes%strain, u => modes%motion, gamma => modes%system%mass)
      do k = 1, size(modes%period)
        push = sqrt(gamma)*(modes%period(k)**(-2) - system%mass_weight)   ! over √γ, lest γ take it out of range
        force = dot_product(system%force, x(:, k)) - dot_product(system%pushed, u(:, k))/modes%period(k)**2
        rounding = norm2(system%force)*norm2(x(:, k)) + norm2(system%pushed)/modes%period(k)**2
        if (rounding < push) u(system%tip_row, k) = force/push
      end do
    end associate
  end subroutine sharpen_tip

  pure function last_coefficients(modes) result(largest)
    !! The largest of the last coefficients of v, and of rψ where there is shear: how far a mode is from being resolved, (modes).
    type(strain_modes), intent(in) :: modes
    real(dp) :: largest(size(modes%period))
    integer :: last
    last = modes%system%functions + 2
    largest = maxval(abs(modes%motion(last - watched + 1:last, :)), dim=1)
    if (modes%system%turn_row == 0) return
    last = modes%system%turn_row + modes%system%functions
    largest = max(largest, maxval(abs(modes%motion(last - watched + 1:last, :)), dim=1))
  end function last_coefficients

end module bw_strain_modes
