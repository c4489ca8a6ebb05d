module bw_strain_modes
  !! Modes of a beam of pieces with tension, uniform or tapering, with as many basis functions as needed.
  !!
  !! With S = LLᵀ (bw_strain_system) the singular values of B L⁻ᵀ are p = (β² + σ)^(−½), and its left singular vectors
  !! hold the coefficients of v and ψ: neither M nor v is a difference of large numbers, so all modes keep their digits.
  !! β² follows from p, and again from Rayleigh's quotient of modes of mass 1: the elastic stiffness λ plus the terms of
  !! rotation. The error of the quotient is the square of that of the shape. It is used where β² is a small difference
  !! from p, and the agreement of the two is checked.
  !!
  !! **Errors**: β² + σ within 1e-13 relatively for 200 modes, Ω from 0 to 1000 and every slenderness (tests).
  use bw_double_double, only: dd, to_dd, operator(+)
  use bw_kinds, only: dp
  use bw_lapack, only: dpotrf, dtrsm
  use bw_local_waves, only: local_wave, mean_rule, wave_section
  use bw_missing, only: missing
  use bw_mode_demand, only: mode_demand
  use bw_monitor, only: monitor_type, stops
  use bw_piece_beam, only: holds_tip, side_of_tip
  use bw_piece_strains, only: ends_of, motions_of, piece_motions, strains_inside
  use bw_singular_values, only: singular_values
  use bw_strain_basis, only: basis_values
  use bw_strain_critical, only: critical_speed_of, initial_basis_sizes
  use bw_strain_set, only: strain_set
  use bw_strain_squares, only: find_squares
  use bw_strain_system, only: build_system, strain_system, turn_of_piece, unfactored
  use bw_varying_beam, only: value_of, varying_beam
  implicit none (type, external)
  private
  public :: strain_modes, modes_with

  integer, parameter :: most_functions = 2000      !! most functions in all pieces together
  integer, parameter :: watched = 2                !! last coefficients that are checked: one of two neighbours may vanish by parity

contains

  subroutine strain_modes(given, count, struck, set, monitor, demand)
    !! Find the first `count` modes; not `resolved`, with zero arrays, if there are none.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: count                   !! ≥ 1
    integer, intent(in) :: struck                  !! joint at which the mass strikes
    type(strain_set), intent(out) :: set
    class(monitor_type), intent(inout), optional :: monitor   !! none are found if it requests a stop
    type(mode_demand), intent(in), optional :: demand
    type(mode_demand) :: wanted
    integer :: functions(size(given%beam%piece))
    real(dp) :: last
    if (present(demand)) wanted = demand
    functions = initial_basis_sizes(given, count, wanted)
    do
      call modes_with(given, count, functions, struck, set, last, monitor)
      if (stops(monitor) .or. .not. set%resolved .or. last < wanted%negligible()) exit
      functions = functions + functions/2
      set%resolved = sum(functions) <= most_functions
      if (.not. set%resolved) exit
    end do
    if (stops(monitor)) set%resolved = .false.
    if (.not. set%resolved) call leave_empty(given, count, set)
    set%given = given
    if (.not. wanted%waves) return
    if (stops(monitor)) return
    if (set%resolved) call find_waves(given, set)
    set%critical_speed = critical_speed_of(given)
  end subroutine strain_modes

  subroutine modes_with(given, count, functions, struck, set, last, monitor)
    !! Find modes with given numbers of functions, without their waves.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: count
    integer, intent(in) :: functions(:)            !! of each strain in a piece, (pieces)
    integer, intent(in) :: struck
    type(strain_set), intent(out) :: set
    real(dp), intent(out) :: last                  !! largest last coefficient of any mode: small if the functions suffice
    class(monitor_type), intent(inout), optional :: monitor
    type(strain_system) :: system
    type(dd) :: shift
    real(dp), allocatable :: period(:), motion(:, :), strain(:, :)
    last = huge(last)
    set%count = count
    call factor_system(given, functions, system, shift, set%resolved)
    if (set%resolved) set%resolved = count <= size(system%stiffness, 1)
    if (.not. set%resolved) return
    call solve_system(count, system, period, motion, strain, set%resolved, monitor)
    if (.not. set%resolved) return
    set%given = given
    call find_motions(system, motion, strain, set)
    call find_squares(given, period, shift, set)
    last = maxval(last_coefficients(set))
    call normalise(struck, set)
  end subroutine modes_with

  subroutine factor_system(given, functions, system, shift, factored)
    !! Build the system with the smallest shift for which S is positive definite, and replace S by its factor L. In
    !! plane σ = Ω² leaves K and Ω² times the rotary inertia, so A, possibly a small difference, is never built. Out of
    !! plane A itself is positive definite unless rotary inertia makes it unstable. A free beam has a shift of 1 more.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: functions(:)
    type(strain_system), intent(out) :: system
    type(dd), intent(out) :: shift                 !! σ
    logical, intent(out) :: factored
    type(dd) :: shifts(3)
    integer :: i, info
    shifts = [dd(), given%beam%spin_squared, given%beam%spin_squared + to_dd(1.0_dp)]
    do i = merge(2, 1, given%beam%in_plane), size(shifts)
      shift = shifts(i)
      call build_system(given, functions, shift, system)
      associate (s => system%stiffness)
        call dpotrf('L', size(s, 1), s, size(s, 1), info)
      end associate
      factored = info == 0
      if (factored) return
    end do
  end subroutine factor_system

  subroutine solve_system(count, system, period, motion, strain, resolved, monitor)
    !! Find the first modes with BᵀB-norm 1.
    integer, intent(in) :: count                   !! ≤ unknowns
    type(strain_system), intent(inout) :: system   !! factored; its matrices are overwritten
    real(dp), allocatable, intent(out) :: period(:)        !! p = (β² + σ)^(−½), descending, (modes)
    real(dp), allocatable, intent(out) :: motion(:, :)     !! rows of B, (rows, modes)
    real(dp), allocatable, intent(out) :: strain(:, :)     !! unknowns, L⁻ᵀ(right singular vector)/p, (unknowns, modes)
    logical, intent(out) :: resolved               !! LAPACK succeeded
    class(monitor_type), intent(inout), optional :: monitor
    integer :: info, k
    resolved = .false.
    associate (s => system%stiffness, b => system%mass_root)
      call dtrsm('R', 'L', 'T', 'N', size(b, 1), size(b, 2), 1.0_dp, s, size(s, 1), b, size(b, 1))
      if (stops(monitor)) return
      call singular_values(b, count, period, motion, strain, info)
      if (info /= 0) return
      if (stops(monitor)) return
      resolved = all(period > 0.0_dp)
      if (.not. resolved) return
      call dtrsm('L', 'L', 'T', 'N', size(strain, 1), count, 1.0_dp, s, size(s, 1), strain, size(strain, 1))
      do k = 1, count
        strain(:, k) = strain(:, k)/period(k)
      end do
    end associate
  end subroutine solve_system

  subroutine find_motions(system, motion, strain, set)
    !! Find the motions of pieces and joints in modes of mass 1. Deflections are taken from the left singular vectors,
    !! which have more digits than strains.
    type(strain_system), intent(in) :: system
    real(dp), intent(in) :: motion(:, :), strain(:, :)     !! from `solve_system`
    type(strain_set), intent(inout) :: set
    integer :: i, n, row
    associate (beam => set%given%beam, layout => system%layout)
      n = size(beam%piece)
      allocate (set%piece(n), set%deflection(0:n, set%count), set%turning(0:n, set%count))
      associate (joints => strain(layout%of_joints, :), m => layout%joints%number)
        set%deflection = matmul(transpose(layout%joints%deflection(:m, :)), joints)
        set%turning = matmul(transpose(layout%joints%turning(:m, :)), joints)
      end associate
      row = 0
      if (beam%root%on_hub) set%hub_turn = strain(size(strain, 1), :)
      do i = 1, n
        associate (piece => beam%piece(i), f => layout%functions(i))
          set%piece(i) = motions_of(piece, f, layout%shear, ends_and_inside(i))
          set%piece(i)%deflection = unfactored(set%given%law(i)%mass, motion(row + 1:row + f + 2, :)) &
            /sqrt(piece%mass%hi*piece%length%hi)
          if (beam%root%on_hub) set%piece(i)%deflection = set%piece(i)%deflection &
            - spread(turn_of_piece(set%given, i, f + 2), 2, set%count)*spread(set%hub_turn, 1, f + 2)
          row = row + f + 2
          if (piece%rotary%hi > 0.0_dp) row = row + f + 1
        end associate
      end do
    end associate
  contains
    pure function ends_and_inside(i) result(columns)
      integer, intent(in) :: i
      real(dp), allocatable :: columns(:, :)
      integer :: inside
      associate (layout => system%layout)
        inside = strains_inside(layout%functions(i), layout%shear)
        allocate (columns(4 + inside, size(strain, 2)))
        columns(:4, :) = matmul(ends_of(layout, i), strain(layout%of_joints, :))
        columns(5:, :) = strain(layout%inside(i) + 1:layout%inside(i) + inside, :)
      end associate
    end function ends_and_inside
  end subroutine find_motions

  pure function last_coefficients(set) result(largest)
    !! Return the largest of the last coefficients of √(mL) v and √(ρIL) ψ in any piece, (modes).
    type(strain_set), intent(in) :: set
    real(dp) :: largest(set%count)
    integer :: i, n
    largest = 0.0_dp
    do i = 1, size(set%piece)
      associate (piece => set%given%beam%piece(i), v => set%piece(i)%deflection, psi => set%piece(i)%turning)
        n = size(v, 1)
        largest = max(largest, sqrt(piece%mass%hi*piece%length%hi)*maxval(abs(v(n - watched + 1:, :)), dim=1))
        largest = max(largest, sqrt(piece%rotary%hi*piece%length%hi)*maxval(abs(psi(n - watched:, :)), dim=1))
      end associate
    end do
  end function last_coefficients

  pure subroutine normalise(struck, set)
    !! Scale modes from mass 1 to ∫Φ² dξ = 1 and a tip value of sign (−1)^k.
    integer, intent(in) :: struck
    type(strain_set), intent(inout) :: set
    real(dp) :: scale, side
    logical :: held(2)
    integer :: i, k, n
    n = size(set%piece)
    held = holds_tip(set%given%beam)
    do k = 1, set%count
      scale = 0.0_dp
      do i = 1, size(set%piece)
        scale = scale + set%given%beam%piece(i)%length%hi*sum(whole(i)**2)
      end do
      scale = 1.0_dp/sqrt(scale)
      set%modal_mass(k) = scale**2
      side = side_of_tip(set%given%beam, [set%deflection(n, k), set%turning(n, k)], last_curvature(set%piece(n), k))
      if (k == 1 .and. allocated(set%hub_turn)) side = set%hub_turn(1)
      if (mod(k, 2) == 0 .neqv. side > 0.0_dp) scale = -scale
      if (allocated(set%hub_turn)) set%hub_turn(k) = scale*set%hub_turn(k)
      if (held(1)) set%deflection(n, k) = 0.0_dp
      if (held(2)) set%turning(n, k) = 0.0_dp
      set%deflection(:, k) = scale*set%deflection(:, k)
      set%turning(:, k) = scale*set%turning(:, k)
      do i = 1, size(set%piece)
        associate (piece => set%piece(i))
          piece%strain(:, k) = scale*piece%strain(:, k)
          piece%turning(:, k) = scale*piece%turning(:, k)
          piece%slope(:, k) = scale*piece%slope(:, k)
          piece%deflection(:, k) = scale*piece%deflection(:, k)
        end associate
      end do
    end do
    set%struck_joint = struck
    set%struck = set%deflection(struck, :)
    if (allocated(set%hub_turn)) set%struck = set%struck &
      + set%hub_turn*(set%given%beam%root%hub_radius%hi + sum(set%given%beam%piece(:struck)%length%hi))
  contains
    pure function whole(i) result(deflection)
      !! Include the rotation of a free hub.
      integer, intent(in) :: i
      real(dp) :: deflection(size(set%piece(i)%deflection, 1))
      deflection = set%piece(i)%deflection(:, k)
      if (allocated(set%hub_turn)) deflection = deflection + set%hub_turn(k)*turn_of_piece(set%given, i, size(deflection))
    end function whole
  end subroutine normalise

  pure real(dp) function last_curvature(piece, k) result(curvature)
    !! Return it at the outer end of a piece, up to a positive factor.
    type(piece_motions), intent(in) :: piece
    integer, intent(in) :: k                       !! the mode
    real(dp) :: values(size(piece%turning, 1) - 1, 1)
    values = basis_values(size(values, 1), [1.0_dp])
    curvature = dot_product(values(:, 1), piece%strain(:size(values, 1), k))
  end function last_curvature

  subroutine find_waves(given, set)
    !! Find mean wave numbers over the beam, and the velocities.
    type(varying_beam), intent(in) :: given
    type(strain_set), intent(inout) :: set
    real(dp), allocatable :: z(:), weight(:), p(:), rise(:)
    real(dp) :: slope
    integer :: i, k
    call mean_rule(z, weight)
    allocate (set%alpha(set%count), source=0.0_dp)
    allocate (set%phase_velocity(set%count), set%group_velocity(set%count), source=missing)
    allocate (p(size(z)), rise(size(z)))
    do k = 1, set%count
      slope = 0.0_dp
      associate (square => set%beta_squared(k)%hi)
        do i = 1, size(set%piece)
          associate (piece => given%beam%piece(i), spin => given%beam%spin_squared%hi)
            call local_wave(sections_of(given, i, 1.0_dp - z**2), spin, given%beam%in_plane, square, p, rise)
            set%alpha(k) = set%alpha(k) + piece%length%hi*sum(weight*p)
            slope = slope + piece%length%hi*sum(weight*rise)
          end associate
        end do
        if (k == 1 .and. given%beam%root%on_hub) set%alpha(k) = 0.0_dp       ! rigid rotation has no wave
        if (square >= 0.0_dp .and. set%alpha(k) > 0.0_dp) set%phase_velocity(k) = sqrt(square)/set%alpha(k)
        if (square > 0.0_dp .and. slope > 0.0_dp) set%group_velocity(k) = 0.5_dp/(sqrt(square)*slope)
      end associate
    end do
  end subroutine find_waves

  pure function sections_of(given, i, x) result(section)
    !! Return the properties of the beam at places of a piece, (places).
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: i
    real(dp), intent(in) :: x(:)                   !! from 0 to 1 over the piece
    type(wave_section) :: section(size(x))
    associate (piece => given%beam%piece(i), law => given%law(i))
      section%stiffness = piece%stiffness%hi*value_of(law%stiffness, x)
      section%mass = piece%mass%hi*value_of(law%mass, x)
      section%compliance = piece%compliance%hi/value_of(law%shear, x)
      section%rotary = piece%rotary%hi*value_of(law%rotary, x)
      section%tension = given%beam%spin_squared%hi*value_of(given%tension(i), x)
    end associate
  end function sections_of

  pure subroutine leave_empty(given, count, set)
    !! Fill a set whose modes could not be found with zeros.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: count
    type(strain_set), intent(out) :: set
    integer :: i, n
    n = size(given%beam%piece)
    set%count = count
    set%resolved = .false.
    allocate (set%alpha(count), set%phase_velocity(count), set%group_velocity(count), source=missing)
    allocate (set%modal_mass(count), source=1.0_dp)
    allocate (set%struck(count), set%rotation(count), set%deflection(0:n, count), set%turning(0:n, count), source=0.0_dp)
    set%beta_squared = spread(dd(), 1, count)
    allocate (set%piece(n))
    do i = 1, n
      associate (piece => set%piece(i))
        allocate (piece%strain(3, count), piece%turning(4, count), piece%slope(4, count), piece%deflection(5, count), source=0.0_dp)
      end associate
    end do
  end subroutine leave_empty

end module bw_strain_modes
