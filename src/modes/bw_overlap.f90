module bw_overlap
  !! What one set of modes in closed form sees of a motion written in another: the sums of Eqs 23 and 26 without
  !! quadrature.
  !!
  !! The two-shape identity of v'''' = α⁴v gives, for a loaded shape Φ̄_k and a free one φ_i,
  !! ∫Φ̄_kφ_i dξ = Φ̄_k'''(1)φ_i(1)/(ᾱ_k⁴ − α_i⁴), Φ̄_k'''(1) = −γᾱ_k⁴Φ̄_k(1); with the mass's own term γΦ̄_k(1)φ_i(1)
  !! the sum is γΦ̄_k(1)φ_i(1) α_i⁴/(α_i⁴ − ᾱ_k⁴).
  use bw_kinds, only: dp
  use bw_double_double, only: add_exactly
  use bw_root_difference, only: fourth_power_difference
  use bw_shape, only: shape_type
  implicit none (type, external)
  private
  public :: overlap_with_tip_mass, overlap_without_mass

  real(dp), parameter :: pi = acos(-1.0_dp)

contains

  pure function overlap_with_tip_mass(loaded, free, amplitude) result(sums)
    !! Σ_i (∫Φ̄_kφ_i dξ + γΦ̄_k(1)φ_i(1)) a_i: Eq. 26 times M̄_k.
    !! **Errors**: within 1e-13 of the sum of the terms' magnitudes.
    type(shape_type), intent(in) :: loaded(:)     !! modes Φ̄_k with the mass, any
    type(shape_type), intent(in) :: free(:)       !! modes φ_i without it, γ = 0, from the first
    real(dp), intent(in) :: amplitude(:)          !! a_i, (size(free))
    real(dp) :: sums(size(loaded))
    sums = weighted_sums(loaded, free, amplitude*free%alpha**4, own=amplitude)
  end function overlap_with_tip_mass

  pure function overlap_without_mass(onto, from, amplitude) result(sums)
    !! Σ_i ∫Φ_kφ_i dξ a_i: the beam's part alone.
    type(shape_type), intent(in) :: onto(:)       !! modes Φ_k, any; these or the others are without mass
    type(shape_type), intent(in) :: from(:)       !! modes φ_i, from the first
    real(dp), intent(in) :: amplitude(:)          !! a_i, (size(from))
    real(dp) :: sums(size(onto))
    if (carries_mass(from)) then
      sums = sums_over_loaded(onto, from, amplitude)
    else
      sums = onto%alpha**4*weighted_sums(onto, from, amplitude, own=amplitude/from%alpha**4)
    end if
  end function overlap_without_mass

  pure logical function carries_mass(shape)
    type(shape_type), intent(in) :: shape(:)
    carries_mass = shape(1)%root%gamma > 0.0_dp
  end function carries_mass

  pure function weighted_sums(loaded, free, weight, own) result(sums)
    !! γΦ̄_k(1) Σ_i φ_i(1) w_i/(α_i⁴ − ᾱ_k⁴); without a mass the limit is own_k, the term i = k alone.
    type(shape_type), intent(in) :: loaded(:), free(:)
    real(dp), intent(in) :: weight(:), own(:)
    real(dp) :: sums(size(loaded))
    integer :: k
    if (.not. carries_mass(loaded)) then
      sums = 0.0_dp
      do k = 1, size(loaded)
        if (loaded(k)%root%k <= size(own)) sums(k) = own(loaded(k)%root%k)
      end do
      return
    end if
    sums = -loaded%tip_force/loaded%alpha*sums_over_gaps(loaded, free, free%tip*weight, .false.)
  end function weighted_sums

  pure function sums_over_loaded(free, loaded, amplitude) result(sums)
    !! φ_i(1) Σ_k γΦ̄_k(1) ᾱ_k⁴ a_k/(α_i⁴ − ᾱ_k⁴).
    type(shape_type), intent(in) :: free(:), loaded(:)
    real(dp), intent(in) :: amplitude(:)          !! a_k, (size(loaded))
    real(dp) :: sums(size(free))
    sums = free%tip*sums_over_gaps(free, loaded, loaded%tip_force*loaded%alpha**3*amplitude, .true.)
  end function sums_over_loaded

  pure function sums_over_gaps(onto, from, weight, onto_free) result(sums)
    !! Σ_k w_k/(α_i⁴ − α_k⁴) for all i at a time, in vector registers; each sum is rounded about once (Neumaier).
    type(shape_type), intent(in) :: onto(:)       !! i, ascending; a few hundred
    type(shape_type), intent(in) :: from(:)       !! k, ascending
    real(dp), intent(in) :: weight(:)             !! (size(from))
    logical, intent(in) :: onto_free              !! `onto` are without the mass, else `from` are
    real(dp) :: sums(size(onto))
    real(dp), dimension(size(onto)) :: eighths, rest, alpha, square, gap, lost
    integer :: i, k
    eighths = onto%root%eighths
    rest = onto%root%rest
    alpha = onto%alpha
    square = alpha**2
    sums = 0.0_dp
    lost = 0.0_dp
    i = 1
    do k = 1, size(from)
      associate (other => from(k))
        gap = (0.25_dp*pi*(eighths - other%root%eighths) + (rest - other%root%rest)) &
          *(alpha + other%alpha)*(square + other%alpha**2)
        do while (i < size(onto) .and. onto(i)%root%k < other%root%k)
          i = i + 1
        end do
        if (onto(i)%root%k == other%root%k) gap(i) = own_gap(onto(i), other, onto_free)
        call add_exactly(weight(k)/gap, sums, lost)
      end associate
    end do
    sums = sums + lost
  end function sums_over_gaps

  elemental real(dp) function own_gap(onto, from, onto_free) result(gap)
    !! α⁴ − ᾱ⁴ of two modes of the same number, which may nearly agree.
    type(shape_type), intent(in) :: onto, from
    logical, intent(in) :: onto_free
    if (onto_free) then
      gap = fourth_power_difference(onto%root, from%root)
    else
      gap = -fourth_power_difference(from%root, onto%root)
    end if
  end function own_gap

end module bw_overlap
