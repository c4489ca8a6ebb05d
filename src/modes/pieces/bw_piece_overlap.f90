module bw_piece_overlap
  !! What modes of a beam of pieces see of a motion written in modes of the same beam with another body at a joint, without
  !! quadrature.
  !!
  !! Let φ_i be modes of the beam and Φ_k those with a body (m, J) more. Both have the same stiffness, so that
  !! (β_i² − B_k²)⟨φ_i, Φ_k⟩ = Λ_k m φ_iΦ_k + B_k² J ψ_iΨ_k at the body, ⟨·,·⟩ the product by all mass and inertia without
  !! it, Λ_k = B_k² (+ Ω² in plane). With the body's mass the product is (λ_i m φ_iΦ_k + B_k² J ψ_iΨ_k)/(β_i² − B_k²).
  !! Modes that hardly differ are integrated instead.
  use bw_double_double, only: add_exactly, dd, operator(-)
  use bw_kinds, only: dp
  use bw_mode_probe, only: piece_system
  use bw_monitor, only: monitor_type, stops
  use bw_piece_products, only: part_of, piece_part, piece_product
  use bw_piece_waves, only: frequency_at, piece_frequency
  implicit none (type, external)
  private
  public :: overlap_sums, mass_product

  real(dp), parameter :: alike = 1.0e-2_dp
    !! product of modes of mass 1 from which it is integrated: the values at the body have lost digits where they are small

  integer, parameter :: asked_every = 64         !! motions after which the monitor is asked

  type, public :: piece_modes
    !! Modes as their amplitudes.
    type(piece_system) :: system
    type(dd), allocatable :: lambda(:)           !! λ_k, (modes)
    type(dd), allocatable :: square(:)           !! β_k², (modes)
    real(dp), allocatable :: amplitude(:, :, :)  !! (4, pieces, modes)
    real(dp), allocatable :: deflection(:, :)    !! at the joints, (joints, modes)
    real(dp), allocatable :: turning(:, :)       !! at the joints, (joints, modes)
    real(dp), allocatable :: mass(:)             !! M_k, (modes)
  end type piece_modes

contains

  function overlap_sums(onto, from, amplitude, with_mass, monitor) result(sums)
    !! Σ_i ⟨Φ_k, φ_i⟩ a_i for all k.
    type(piece_modes), intent(in) :: onto        !! Φ_k
    type(piece_modes), intent(in) :: from        !! φ_i
    real(dp), intent(in) :: amplitude(:)         !! a_i
    logical, intent(in) :: with_mass
      !! the product holds the masses of either beam, but no inertia of a body that only one of them has; else neither
    class(monitor_type), intent(inout), optional :: monitor   !! the sums mean nothing where it asks to stop
    real(dp) :: sums(size(onto%lambda))
    integer, parameter :: most = 512, most_parts = 4096   ! modes, and their pieces, whose numbers stay in the cache
    integer, allocatable :: changed(:)
    integer :: batch, first, j, last
    batch = max(1, min(most, most_parts/size(onto%system%piece)))
    changed = [integer ::]
    do j = 1, size(onto%system%beam%joint)
      if (change_at(onto, from, j, 1) /= 0.0_dp .or. change_at(onto, from, j, 2) /= 0.0_dp) changed = [changed, j]
    end do
    do first = 1, size(sums), batch
      last = min(first + batch - 1, size(sums))
      call find_sums(some_of(onto, first, last), from, amplitude, changed, with_mass, sums(first:last), monitor)
      if (stops(monitor)) return
    end do
  end function overlap_sums

  pure type(piece_modes) function some_of(modes, first, last) result(some)
    !! Neighbours.
    type(piece_modes), intent(in) :: modes
    integer, intent(in) :: first, last
    some = piece_modes(modes%system, modes%lambda(first:last), modes%square(first:last), modes%amplitude(:, :, first:last), &
                       modes%deflection(:, first:last), modes%turning(:, first:last), modes%mass(first:last))
  end function some_of

  subroutine find_sums(onto, from, amplitude, changed, with_mass, sums, monitor)
    !! As those of `overlap_sums`.
    type(piece_modes), intent(in) :: onto, from
    real(dp), intent(in) :: amplitude(:)
    integer, intent(in) :: changed(:)            !! joints at which the beams differ
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

  elemental real(dp) function change_at(onto, from, j, which) result(change)
    !! By how much `onto` has more mass (1) or inertia (2) at a joint.
    type(piece_modes), intent(in) :: onto, from
    integer, intent(in) :: j, which
    if (which == 1) then
      change = onto%system%beam%joint(j)%mass%hi - from%system%beam%joint(j)%mass%hi
    else
      change = onto%system%beam%joint(j)%inertia%hi - from%system%beam%joint(j)%inertia%hi
    end if
  end function change_at

  pure subroutine products_with(onto, from, i, changed, with_mass, parts, known, products)
    !! ⟨Φ_k, φ_i⟩ for all k.
    type(piece_modes), intent(in) :: onto, from
    integer, intent(in) :: i
    integer, intent(in) :: changed(:)            !! joints at which the beams differ
    logical, intent(in) :: with_mass
    type(piece_part), intent(inout) :: parts(:, :)   !! motions of `onto` that have been integrated, (pieces, k)
    logical, intent(inout) :: known(:)           !! these, (k)
    real(dp), intent(out) :: products(:)         !! (k)
    real(dp), dimension(size(products)) :: gap, numerator, moved
    type(piece_part) :: own(size(parts, 1))      ! of φ_i
    logical :: near(size(products))
    real(dp) :: mass, inertia
    integer :: c, j, k
    gap = (from%square(i)%hi - onto%square%hi) + (from%square(i)%lo - onto%square%lo)
    numerator = 0.0_dp
    moved = 0.0_dp
    do c = 1, size(changed)
      j = changed(c)
      mass = change_at(onto, from, j, 1)
      inertia = change_at(onto, from, j, 2)
      associate (v => onto%deflection(j, :)*from%deflection(j, i), psi => onto%turning(j, :)*from%turning(j, i))
        if (mass > 0.0_dp .neqv. with_mass) then
          numerator = numerator + mass*onto%lambda%hi*v
        else
          numerator = numerator + mass*from%lambda(i)%hi*v
        end if
        numerator = numerator + inertia*merge(onto%square%hi, from%square(i)%hi, inertia > 0.0_dp)*psi
        if (with_mass) moved = moved + abs(mass)*v
      end associate
    end do
    products = alike*abs(gap)*sqrt(onto%mass*from%mass(i))
    near = abs(numerator) >= products
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
  end subroutine products_with

  pure function parts_of(modes, k) result(parts)
    !! The motions of all pieces in a mode.
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
    !! ⟨Φ_k, φ_i⟩ by integration: with the mass and inertia that both beams have.
    type(piece_modes), intent(in) :: one, other
    integer, intent(in) :: k, i
    product = product_of(one, k, parts_of(one, k), other, i, parts_of(other, i))
  end function mass_product

  pure real(dp) function product_of(one, k, part, other, i, part_too) result(product)
    !! The same of motions of which all is known.
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
