module bw_piece_overlap
  !! Overlaps of modes of a beam of pieces with those of the same beam with another body at a joint, without quadrature.
  !!
  !! Let φ_i be modes of the beam and Φ_k those with an additional body (m, J) and its springs (k_v, k_θ). Then (β_i² −
  !! B_k²)⟨φ_i, Φ_k⟩ = (Λ_k m − k_v)φ_iΦ_k + (B_k² J − k_θ)ψ_iΨ_k at the body, with ⟨·,·⟩ weighted by all mass and
  !! inertia without it, Λ_k = B_k² (+ Ω² in plane). With the body's mass in the product λ_i replaces Λ_k in the first
  !! term. Nearly equal modes are integrated instead, as are those for which a stiff spring leaves too few digits.
  use bw_double_double, only: add_exactly, dd, operator(-)
  use bw_kinds, only: dp
  use bw_mode_probe, only: piece_system
  use bw_monitor, only: monitor_type, stops
  use bw_piece_products, only: part_of, piece_part, piece_product
  use bw_piece_waves, only: frequency_at, piece_frequency
  implicit none (type, external)
  private
  public :: mass_product, overlap_sums

  real(dp), parameter :: alike = 1.0e-2_dp
    !! product of modes of mass 1 below which it is integrated: small values at the body have lost digits

  real(dp), parameter :: least_gap = sqrt(epsilon(1.0_dp))
    !! relative difference of β² below which its digits do not suffice

  integer, parameter :: asked_every = 64         !! motions between two calls of the monitor
  real(dp), parameter :: least_digits = 1.0e-13_dp  !! error of products of modes of mass 1

  type, public :: piece_modes
    !! Modes by their amplitudes.
    type(piece_system) :: system
    type(dd), allocatable :: lambda(:)           !! λ_k, (modes)
    type(dd), allocatable :: square(:)           !! β_k², (modes)
    real(dp), allocatable :: amplitude(:, :, :)  !! (4, pieces, modes)
    real(dp), allocatable :: deflection(:, :)    !! at the joints, (joints, modes)
    real(dp), allocatable :: turning(:, :)       !! at the joints, (joints, modes)
    real(dp), allocatable :: mass(:)             !! M_k, (modes)
    real(dp), allocatable :: root(:, :)          !! deflection and turning at the root, (2, modes)
  end type piece_modes

  type :: joint_change
    !! The attachments at a joint that `onto` has in addition; joint 0 is the root.
    integer :: joint = 0
    real(dp) :: mass = 0.0_dp, inertia = 0.0_dp
    real(dp) :: stiffness = 0.0_dp, turning_stiffness = 0.0_dp
  end type joint_change

contains

  function overlap_sums(onto, from, amplitude, with_mass, monitor) result(sums)
    !! Return Σ_i ⟨Φ_k, φ_i⟩ a_i for all k.
    type(piece_modes), intent(in) :: onto        !! Φ_k
    type(piece_modes), intent(in) :: from        !! φ_i
    real(dp), intent(in) :: amplitude(:)         !! a_i
    logical, intent(in) :: with_mass
      !! weight by the mass of either beam, but only common inertia; else only by what both have
    class(monitor_type), intent(inout), optional :: monitor   !! the sums are invalid if it requests a stop
    real(dp) :: sums(size(onto%lambda))
    integer, parameter :: most = 512, most_parts = 4096   ! modes, and their pieces, whose data stay in the cache
    type(joint_change), allocatable :: changed(:)
    integer :: batch, first, last
    batch = max(1, min(most, most_parts/size(onto%system%piece)))
    changed = changes_between(onto, from)
    do first = 1, size(sums), batch
      last = min(first + batch - 1, size(sums))
      call find_sums(some_of(onto, first, last), from, amplitude, changed, with_mass, sums(first:last), monitor)
      if (stops(monitor)) return
    end do
  end function overlap_sums

  pure type(piece_modes) function some_of(modes, first, last) result(some)
    !! Return consecutive modes.
    type(piece_modes), intent(in) :: modes
    integer, intent(in) :: first, last
    some = piece_modes(modes%system, modes%lambda(first:last), modes%square(first:last), modes%amplitude(:, :, first:last), &
                       modes%deflection(:, first:last), modes%turning(:, first:last), modes%mass(first:last), &
                       modes%root(:, first:last))
  end function some_of

  subroutine find_sums(onto, from, amplitude, changed, with_mass, sums, monitor)
    !! Find the sums; see `overlap_sums`.
    type(piece_modes), intent(in) :: onto, from
    real(dp), intent(in) :: amplitude(:)
    type(joint_change), intent(in) :: changed(:)  !! joints at which the beams differ
    logical, intent(in) :: with_mass
    real(dp), intent(out) :: sums(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: lost(size(sums)), terms(size(sums))
    type(piece_part) :: parts(size(onto%system%piece), size(sums))
    logical :: known(size(sums))
    integer :: i
    known = .false.
    sums = 0.0_dp
    lost = 0.0_dp
    do i = 1, size(amplitude)
      if (mod(i, asked_every) == 0) then
        if (stops(monitor)) return
      end if
      call products_with(onto, from, i, changed, with_mass, parts, known, terms)
      call add_exactly(terms*amplitude(i), sums, lost)
    end do
    sums = sums + lost
  end subroutine find_sums

  pure function changes_between(onto, from) result(changed)
    !! Return the joints at which the beams differ.
    type(piece_modes), intent(in) :: onto, from
    type(joint_change), allocatable :: changed(:)
    type(joint_change) :: change
    integer :: j
    allocate (changed(0))
    associate (root => onto%system%beam%root, root_too => from%system%beam%root)
      change%stiffness = root%stiffness%hi - root_too%stiffness%hi
      change%turning_stiffness = root%turning_stiffness%hi - root_too%turning_stiffness%hi
    end associate
    if (differs(change)) changed = [change]
    do j = 1, size(onto%system%beam%joint)
      associate (joint => onto%system%beam%joint(j), joint_too => from%system%beam%joint(j))
        change = joint_change(j, joint%mass%hi - joint_too%mass%hi, joint%inertia%hi - joint_too%inertia%hi, &
                             joint%stiffness%hi - joint_too%stiffness%hi, &
                             joint%turning_stiffness%hi - joint_too%turning_stiffness%hi)
      end associate
      if (differs(change)) changed = [changed, change]
    end do
  contains
    pure logical function differs(change)
      type(joint_change), intent(in) :: change
      differs = any([change%mass, change%inertia, change%stiffness, change%turning_stiffness] /= 0.0_dp)
    end function differs
  end function changes_between

  pure subroutine joint_motions(modes, j, deflection, turning)
    !! Return the motions of all modes at a joint; 0 is the root.
    type(piece_modes), intent(in) :: modes
    integer, intent(in) :: j
    real(dp), intent(out) :: deflection(:), turning(:)
    if (j == 0) then
      deflection = modes%root(1, :)
      turning = modes%root(2, :)
    else
      deflection = modes%deflection(j, :)
      turning = modes%turning(j, :)
    end if
  end subroutine joint_motions

  pure subroutine products_with(onto, from, i, changed, with_mass, parts, known, products)
    !! Find ⟨Φ_k, φ_i⟩ for all k.
    type(piece_modes), intent(in) :: onto, from
    integer, intent(in) :: i
    type(joint_change), intent(in) :: changed(:)
    logical, intent(in) :: with_mass
    type(piece_part), intent(inout) :: parts(:, :)   !! motions of `onto` used in integrals so far, (pieces, k)
    logical, intent(inout) :: known(:)           !! which of these exist, (k)
    real(dp), intent(out) :: products(:)         !! (k)
    real(dp), dimension(size(products)) :: blurred, gap, moved, numerator, psi, v
    real(dp), dimension(size(from%mass)) :: psi_too, v_too
    type(piece_part) :: own(size(parts, 1))      ! of φ_i
    logical :: near(size(products))
    integer :: c, k
    gap = (from%square(i)%hi - onto%square%hi) + (from%square(i)%lo - onto%square%lo)
    numerator = 0.0_dp
    moved = 0.0_dp
    blurred = 0.0_dp
    do c = 1, size(changed)
      call joint_motions(onto, changed(c)%joint, v, psi)
      call joint_motions(from, changed(c)%joint, v_too, psi_too)
      associate (mass => changed(c)%mass, inertia => changed(c)%inertia, &
                 springs => abs([changed(c)%stiffness, changed(c)%turning_stiffness]))
        numerator = numerator + v*v_too(i)*(mass*merge(onto%lambda%hi, from%lambda(i)%hi, mass > 0.0_dp .neqv. with_mass) &
                                            - changed(c)%stiffness)
        numerator = numerator + psi*psi_too(i)*(inertia*merge(onto%square%hi, from%square(i)%hi, inertia > 0.0_dp) &
                                                - changed(c)%turning_stiffness)
        if (with_mass) moved = moved + abs(mass)*v*v_too(i)
        if (any(springs > 0.0_dp)) blurred = blurred + epsilon(gap)*( &
          springs(1)*(abs(v)/sqrt(from%mass(i)) + abs(v_too(i))/sqrt(onto%mass)) &
          + springs(2)*(abs(psi)*wave(from%square(i)%hi)/sqrt(from%mass(i)) + abs(psi_too(i))*wave(onto%square%hi)/sqrt(onto%mass)))
      end associate
    end do
    products = abs(gap)*sqrt(onto%mass*from%mass(i))
    near = abs(gap) <= least_gap*abs(onto%square%hi) .or. abs(numerator) >= alike*products &
      .or. blurred*sqrt(onto%mass*from%mass(i)) > least_digits*products
    if (any(near)) gap = merge(1.0_dp, gap, near)
    products = numerator/gap
    if (.not. any(near)) return
    own = parts_of(from, i)
    do k = 1, size(products)
      if (.not. near(k)) cycle
      if (.not. known(k)) parts(:, k) = parts_of(onto, k)
      known(k) = .true.
      products(k) = product_of(onto, k, parts(:, k), from, i, own) + moved(k)
    end do
  contains
    elemental real(dp) function wave(square)
      !! Estimate the wave number of a mode.
      real(dp), intent(in) :: square
      wave = 1.0_dp + sqrt(sqrt(abs(square)))
    end function wave
  end subroutine products_with

  pure function parts_of(modes, k) result(parts)
    !! Return the motions of all pieces in a mode.
    type(piece_modes), intent(in) :: modes
    integer, intent(in) :: k
    type(piece_part) :: parts(size(modes%system%piece))
    type(piece_frequency) :: frequency
    integer :: j
    frequency = frequency_at(modes%system%beam, modes%lambda(k))
    do j = 1, size(parts)
      parts(j) = part_of(modes%system%piece(j), frequency, modes%amplitude(:, j, k))
    end do
  end function parts_of

  pure real(dp) function mass_product(one, k, other, i) result(product)
    !! Return ⟨Φ_k, φ_i⟩ by integration, with the mass and inertia of both beams.
    type(piece_modes), intent(in) :: one, other
    integer, intent(in) :: k, i
    product = product_of(one, k, parts_of(one, k), other, i, parts_of(other, i))
  end function mass_product

  pure real(dp) function product_of(one, k, part, other, i, part_too) result(product)
    !! Return the same for motions with known end states.
    type(piece_modes), intent(in) :: one, other
    integer, intent(in) :: k, i
    type(piece_part), intent(in) :: part(:), part_too(:)   !! (pieces)
    integer :: j
    product = 0.0_dp
    do j = 1, size(part)
      associate (joint => one%system%beam%joint(j), joint_too => other%system%beam%joint(j))
        product = product + piece_product(one%system%piece(j), part(j), part_too(j)) &
          + min(joint%mass%hi, joint_too%mass%hi)*one%deflection(j, k)*other%deflection(j, i) &
          + min(joint%inertia%hi, joint_too%inertia%hi)*one%turning(j, k)*other%turning(j, i)
      end associate
    end do
  end function product_of

end module bw_piece_overlap
