module bw_overlap
  !! What one set of modes in closed form sees of a motion written in another: the sums of Eqs 23 and 26 without
  !! quadrature.
  !!
  !! The two-shape identity of v'''' = α⁴v gives, for a loaded shape Φ̄_k and a free one φ_i,
  !! ∫Φ̄_kφ_i dξ = Φ̄_k'''(1)φ_i(1)/(ᾱ_k⁴ − α_i⁴), Φ̄_k'''(1) = −γᾱ_k⁴Φ̄_k(1); with the mass's own term γΦ̄_k(1)φ_i(1)
  !! the sum is γΦ̄_k(1)φ_i(1) α_i⁴/(α_i⁴ − ᾱ_k⁴).
  use bw_frequency_equation, only: root_type
  use bw_gap_sums, only: gap_sums
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type
  use bw_root_list, only: batch
  use bw_shape, only: shape_type, shapes_of
  implicit none (type, external)
  private
  public :: overlap_with_tip_mass, overlap_without_mass

contains

  function overlap_with_tip_mass(loaded, free, amplitude, monitor) result(sums)
    !! Σ_i (∫Φ̄_kφ_i dξ + γΦ̄_k(1)φ_i(1)) a_i: Eq. 26 times M̄_k.
    !! **Errors**: within 1e-13 of the sum of the terms' magnitudes.
    type(root_type), intent(in) :: loaded(:)      !! of modes Φ̄_k with the mass, any
    type(root_type), intent(in) :: free(:)        !! of modes φ_i without it, γ = 0, from the first
    real(dp), intent(in) :: amplitude(:)          !! a_i, (size(free))
    class(monitor_type), intent(inout), optional :: monitor   !! the sums mean nothing where it asks to stop
    real(dp) :: sums(size(loaded))
    if (carries_mass(loaded)) then
      sums = gap_sums(loaded, free, by_tip(free, 4, amplitude), .false., monitor)
      sums = by_mass(loaded, 0, -sums)
    else
      sums = own(loaded, amplitude)
    end if
  end function overlap_with_tip_mass

  function overlap_without_mass(onto, from, amplitude, monitor) result(sums)
    !! Σ_i a_i∫Φ_kφ_i dξ, without the mass.
    type(root_type), intent(in) :: onto(:)        !! of modes Φ_k, any; these or the others are without mass
    type(root_type), intent(in) :: from(:)        !! of modes φ_i, from the first
    real(dp), intent(in) :: amplitude(:)          !! a_i, (size(from))
    class(monitor_type), intent(inout), optional :: monitor   !! as above
    real(dp) :: sums(size(onto))
    if (carries_mass(from)) then
      sums = gap_sums(onto, from, by_mass(from, 4, amplitude), .true., monitor)
      sums = by_tip(onto, 0, sums)
    else if (carries_mass(onto)) then
      sums = gap_sums(onto, from, by_tip(from, 0, amplitude), .false., monitor)
      sums = by_mass(onto, 4, -sums)
    else
      sums = own(onto, amplitude)
    end if
  end function overlap_without_mass

  pure logical function carries_mass(root)
    !! Whether the modes are those with the mass at the tip.
    type(root_type), intent(in) :: root(:)
    carries_mass = root(1)%gamma > 0.0_dp
  end function carries_mass

  pure function own(onto, amplitude) result(sums)
    !! The sums where there is no mass: the two sets are one, and of each sum the term i = k is left.
    type(root_type), intent(in) :: onto(:)
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(size(onto))
    integer :: k
    sums = 0.0_dp
    do k = 1, size(onto)
      if (onto(k)%k <= size(amplitude)) sums(k) = amplitude(onto(k)%k)
    end do
  end function own

  pure function by_tip(root, power, values) result(products)
    !! φ(1)α^power times values.
    type(root_type), intent(in) :: root(:)
    integer, intent(in) :: power
    real(dp), intent(in) :: values(:)
    real(dp) :: products(size(root))
    type(shape_type) :: shape(batch)
    integer :: first, last
    do first = 1, size(root), batch
      last = min(first + batch - 1, size(root))
      associate (s => shape(:last - first + 1))
        s = shapes_of(root(first:last))
        products(first:last) = s%tip*(values(first:last)*s%alpha**power)
      end associate
    end do
  end function by_tip

  pure function by_mass(root, power, values) result(products)
    !! γΦ(1)α^power times values.
    type(root_type), intent(in) :: root(:)
    integer, intent(in) :: power
    real(dp), intent(in) :: values(:)
    real(dp) :: products(size(root))
    type(shape_type) :: shape(batch)
    integer :: first, last
    do first = 1, size(root), batch
      last = min(first + batch - 1, size(root))
      associate (s => shape(:last - first + 1))
        s = shapes_of(root(first:last))
        products(first:last) = s%tip_force/s%alpha*values(first:last)*s%alpha**power
      end associate
    end do
  end function by_mass

end module bw_overlap
