module bw_tension_modes
  !! Modes of a beam of pieces with tension, in as many functions as they need.
  !!
  !! As in bw_galerkin β² comes from singular values and again from Rayleigh's quotient.
  use bw_double_double, only: dd, to_dd, operator(*), operator(-), operator(/)
  use bw_kinds, only: dp
  use bw_lapack, only: dsygv
  use bw_local_waves, only: local_wave, mean_rule, wave_section
  use bw_missing, only: missing
  use bw_mode_demand, only: mode_demand
  use bw_monitor, only: monitor_type, stops
  use bw_piece_strains, only: ends_of, motions_of, strain_layout, strains_inside
  use bw_strain_basis, only: times_quadratic
  use bw_strain_modes, only: solve_system, strain_modes
  use bw_strain_set, only: choose_squares
  use bw_tension_set, only: tension_set
  use bw_tension_system, only: build_tension_system, tension_beam, tension_matrices
  implicit none (type, external)
  private
  public :: tension_modes, modes_with, critical_speed_of_pieces

  integer, parameter :: most_functions = 2000      !! of all pieces together
  integer, parameter :: watched = 4                !! of the last coefficients: neighbours may vanish by parity

contains

  subroutine tension_modes(given, count, struck, set, monitor, demand)
    !! Find the first `count` modes; not `resolved`, with arrays in which nothing moves, where there are none to be had.
    type(tension_beam), intent(in) :: given
    integer, intent(in) :: count                   !! ≥ 1
    integer, intent(in) :: struck                  !! the joint at which the mass strikes
    type(tension_set), intent(out) :: set
    class(monitor_type), intent(inout), optional :: monitor   !! none are found where it asks to stop
    type(mode_demand), intent(in), optional :: demand
    type(mode_demand) :: wanted
    integer :: functions(size(given%beam%piece))
    real(dp) :: last
    if (present(demand)) wanted = demand
    functions = first_guess(given, count, wanted)
    do
      call modes_with(given, count, functions, struck, set, last, monitor)
      if (stops(monitor) .or. .not. set%resolved .or. last < wanted%negligible()) exit
      functions = functions + functions/2
      set%resolved = sum(functions) <= most_functions
      if (.not. set%resolved) exit
    end do
    if (stops(monitor)) set%resolved = .false.
    if (.not. set%resolved) call leave_empty(given, count, set)
    set%beam = given%beam
    if (.not. wanted%waves) return
    if (set%resolved) call find_waves(given, set)
    set%critical_speed = critical_speed_of_pieces(given)
  end subroutine tension_modes

  pure function first_guess(given, count, wanted) result(functions)
    !! Half a wave needs π/2 polynomials, and waves share among the pieces as they do in the beam; the ends of each need more, and
    !! layers where tension leaves bending to them, 4√(L/δ), δ = √(B(1 + sT)/T). Thin layers are pieces of their own
    !! (bw_tension_layers), which leave a few to the long ones.
    type(tension_beam), intent(in) :: given
    integer, intent(in) :: count
    type(mode_demand), intent(in) :: wanted
    integer :: functions(size(given%beam%piece))
    real(dp) :: waves(size(functions)), pull       ! half waves in each piece
    integer, parameter :: ends = 20, fewest = 14   ! tuned, as the other numbers are: of half a wave and more, and of none
    real(dp) :: layers                             ! √(L/δ)
    integer :: i
    associate (piece => given%beam%piece)
      waves = piece%length%hi*sqrt(sqrt(piece%mass%hi/piece%stiffness%hi))
      waves = count*waves/sum(waves)
      do i = 1, size(functions)
        functions(i) = wanted%ends(fewest + ceiling((ends - fewest)*min(1.0_dp, waves(i)))) + ceiling(1.75_dp*waves(i))
        pull = given%beam%spin_squared%hi*given%tension(1, i)
        pull = pull/(piece(i)%stiffness%hi*(1.0_dp + piece(i)%compliance%hi*pull))
        layers = sqrt(sqrt(pull)*piece(i)%length%hi)
        functions(i) = max(functions(i), ceiling(min(5.4_dp*layers, 24.0_dp)), ceiling(min(2.5_dp*layers, 60.0_dp)))
      end do
    end associate
  end function first_guess

  subroutine modes_with(given, count, functions, struck, set, last, monitor)
    !! Find modes in given numbers of functions, without their waves.
    type(tension_beam), intent(in) :: given
    integer, intent(in) :: count
    integer, intent(in) :: functions(:)            !! of each strain in a piece, (n)
    integer, intent(in) :: struck
    type(tension_set), intent(out) :: set
    real(dp), intent(out) :: last                  !! their largest last coefficient: small where the functions were enough
    class(monitor_type), intent(inout), optional :: monitor
    type(strain_layout) :: layout
    type(strain_modes) :: modes
    last = huge(last)
    set%count = count
    call build_tension_system(given, functions, layout, modes%system)
    set%resolved = count <= layout%unknowns
    if (.not. set%resolved) return
    call solve_system(count, modes, monitor)
    set%resolved = modes%resolved
    if (.not. set%resolved) return
    set%beam = given%beam
    call find_motions(given, layout, modes, set)
    call find_squares(given, modes, set)
    last = maxval(last_coefficients(set))
    call normalise(struck, set)
  end subroutine modes_with

  pure subroutine find_motions(given, layout, modes, set)
    !! What the pieces and the joints do in modes of mass 1. Deflections are those of the left singular vectors: they have
    !! digits where strains have lost them.
    type(tension_beam), intent(in) :: given
    type(strain_layout), intent(in) :: layout
    type(strain_modes), intent(in) :: modes
    type(tension_set), intent(inout) :: set
    integer :: i, n, row
    n = size(given%beam%piece)
    allocate (set%piece(n), set%deflection(0:n, set%count), set%turning(0:n, set%count))
    associate (joints => modes%strain(layout%of_joints, :), m => layout%joints%number)
      set%deflection = matmul(transpose(layout%joints%deflection(:m, :)), joints)
      set%turning = matmul(transpose(layout%joints%turning(:m, :)), joints)
    end associate
    row = 0
    do i = 1, n
      associate (piece => given%beam%piece(i), f => layout%functions(i))
        set%piece(i) = motions_of(piece, f, layout%shear, ends_and_inside(i))
        set%piece(i)%deflection = modes%motion(row + 1:row + f + 2, :)/sqrt(piece%mass%hi*piece%length%hi)
        row = row + f + 2
        if (piece%rotary%hi > 0.0_dp) row = row + f + 1
      end associate
    end do
  contains
    pure function ends_and_inside(i) result(columns)
      integer, intent(in) :: i
      real(dp), allocatable :: columns(:, :)
      integer :: inside
      inside = strains_inside(layout%functions(i), layout%shear)
      allocate (columns(4 + inside, size(modes%strain, 2)))
      columns(:4, :) = matmul(ends_of(layout, i), modes%strain(layout%of_joints, :))
      columns(5:, :) = modes%strain(layout%inside(i) + 1:layout%inside(i) + inside, :)
    end function ends_and_inside
  end subroutine find_motions

  pure subroutine find_squares(given, modes, set)
    !! β², of modes of mass 1. The terms of rotation are about Ω², and what rounding leaves where they cancel is 0: a beam that
    !! turns freely about the axis of its rotation is at rest anywhere.
    type(tension_beam), intent(in) :: given
    type(strain_modes), intent(in) :: modes
    type(tension_set), intent(inout) :: set
    real(dp), parameter :: rest = 16.0_dp*epsilon(1.0_dp)
    type(dd) :: elastic(set%count), p
    integer :: k
    allocate (set%beta_squared(set%count), set%rotation(set%count), set%modal_mass(set%count))
    set%modal_mass = 1.0_dp
    do k = 1, set%count
      p = to_dd(modes%period(k))
      set%beta_squared(k) = to_dd(1.0_dp)/(p*p) - modes%system%shift
    end do
    set%rotation = huge(1.0_dp)                    ! asks for strains alone
    elastic = set%elastic()
    set%rotation = [(rotation_term(given, set, k), k=1, set%count)]
    call choose_squares(set, elastic%hi + set%rotation, modes%system%shift%hi)
    where (abs(set%beta_squared%hi) <= rest*given%beam%spin_squared%hi) set%beta_squared = dd()
  end subroutine find_squares

  pure real(dp) function rotation_term(given, set, k) result(term)
    !! Work against the tension, less Ω² times what of the mass the centrifugal force acts on.
    type(tension_beam), intent(in) :: given
    type(tension_set), intent(in) :: set
    integer, intent(in) :: k
    integer :: i
    term = 0.0_dp
    do i = 1, size(set%piece)
      associate (piece => given%beam%piece(i), joint => given%beam%joint(i), slope => set%piece(i)%slope(:, k))
        term = term + piece%length%hi*dot_product(slope, times_quadratic(given%tension(:, i), slope))
        if (given%beam%in_plane) then
          term = term - piece%mass%hi*piece%length%hi*sum(set%piece(i)%deflection(:, k)**2) &
            - joint%mass%hi*set%deflection(i, k)**2
        else
          term = term - piece%rotary%hi*piece%length%hi*sum(set%piece(i)%turning(:, k)**2)
        end if
      end associate
    end do
    term = given%beam%spin_squared%hi*term
  end function rotation_term

  pure function last_coefficients(set) result(largest)
    !! The largest of the last coefficients of √(mL) v, and of √(ρIL) ψ, in any piece, (modes).
    type(tension_set), intent(in) :: set
    real(dp) :: largest(set%count)
    integer :: i, n
    largest = 0.0_dp
    do i = 1, size(set%piece)
      associate (piece => set%beam%piece(i), v => set%piece(i)%deflection, psi => set%piece(i)%turning)
        n = size(v, 1)
        largest = max(largest, sqrt(piece%mass%hi*piece%length%hi)*maxval(abs(v(n - watched + 1:, :)), dim=1))
        largest = max(largest, sqrt(piece%rotary%hi*piece%length%hi)*maxval(abs(psi(n - watched:, :)), dim=1))
      end associate
    end do
  end function last_coefficients

  pure subroutine normalise(struck, set)
    !! Scale modes from mass 1 to ∫Φ² dξ = 1 and a tip value of sign (−1)^k.
    integer, intent(in) :: struck
    type(tension_set), intent(inout) :: set
    real(dp) :: scale
    integer :: i, k
    do k = 1, set%count
      scale = 0.0_dp
      do i = 1, size(set%piece)
        scale = scale + set%beam%piece(i)%length%hi*sum(set%piece(i)%deflection(:, k)**2)
      end do
      scale = 1.0_dp/sqrt(scale)
      set%modal_mass(k) = scale**2
      if (mod(k, 2) == 0 .neqv. set%deflection(size(set%piece), k) > 0.0_dp) scale = -scale
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
  end subroutine normalise

  subroutine find_waves(given, set)
    !! Mean wave numbers over the beam, and the velocities that follow from them.
    type(tension_beam), intent(in) :: given
    type(tension_set), intent(inout) :: set
    real(dp), allocatable :: z(:), weight(:), tension(:), p(:), rise(:)
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
          associate (t => given%tension(:, i), piece => given%beam%piece(i))
            tension = given%beam%spin_squared%hi*(t(1) + (1.0_dp - z**2)*(t(2) + (1.0_dp - z**2)*t(3)))
            call local_wave(wave_section(piece%stiffness%hi, piece%mass%hi, piece%compliance%hi, piece%rotary%hi, &
                                         given%beam%spin_squared%hi, given%beam%in_plane), square, tension, p, rise)
            set%alpha(k) = set%alpha(k) + piece%length%hi*sum(weight*p)
            slope = slope + piece%length%hi*sum(weight*rise)
          end associate
        end do
        if (square >= 0.0_dp .and. set%alpha(k) > 0.0_dp) set%phase_velocity(k) = sqrt(square)/set%alpha(k)
        if (square > 0.0_dp .and. slope > 0.0_dp) set%group_velocity(k) = 0.5_dp/(sqrt(square)*slope)
      end associate
    end do
  end subroutine find_waves

  pure subroutine leave_empty(given, count, set)
    !! Make a set whose modes could not be found: arrays of the right lengths, in which nothing moves.
    type(tension_beam), intent(in) :: given
    integer, intent(in) :: count
    type(tension_set), intent(out) :: set
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

  type(dd) function critical_speed_of_pieces(given) result(omega)
    !! The lowest Ω at which a mode is unstable, 0 where there is none: there Kx = Ω²Gx, G being what Ω² takes from the
    !! stiffness; both are linear in Ω². A beam that floats or turns freely has none here.
    type(tension_beam), intent(in) :: given
    integer, parameter :: most = 40, fewest = 12   ! functions of a piece for the lowest mode, whatever the tension (tuned)
    real(dp), parameter :: long = 0.2_dp           ! a piece that takes all of them; shorter ones as the root of their length
    real(dp), parameter :: rounding = 1.0e-13_dp   ! of the largest value: where tension holds everything, nothing is left but it
    real(dp), allocatable :: stiffness(:, :), push(:, :), value(:), work(:)
    integer :: info
    call tension_matrices(given, max(fewest, min(most, ceiling(most*sqrt(given%beam%piece%length%hi/long)))), stiffness, push)
    associate (n => size(push, 1))
      allocate (value(n), work(64*n))
      call dsygv(1, 'N', 'L', n, push, n, stiffness, n, value, work, size(work), info)
      omega = dd()
      if (info /= 0) return
      if (value(n) > rounding*maxval(abs(value))) omega = to_dd(1.0_dp/sqrt(value(n)))
    end associate
  end function critical_speed_of_pieces

end module bw_tension_modes
