module bw_overlap
  !! What one set of modes sees of a motion written in another: the sums of Eqs 23 and 26 without quadrature.
  !!
  !! The two-shape identity of v'''' = α⁴v gives, for a loaded shape Φ̄_k and a free one φ_i,
  !! ∫Φ̄_kφ_i dξ = Φ̄_k'''(1)φ_i(1)/(ᾱ_k⁴ − α_i⁴), Φ̄_k'''(1) = −γᾱ_k⁴Φ̄_k(1); with the mass's own term γΦ̄_k(1)φ_i(1)
  !! the sum is γΦ̄_k(1)φ_i(1) α_i⁴/(α_i⁴ − ᾱ_k⁴).
  use bw_kinds, only: dp
  use bw_closed_form, only: closed_form_set
  use bw_double_double, only: accurate_sum
  use bw_root_difference, only: fourth_power_difference
  implicit none (type, external)
  private
  public :: overlap_of_beam, overlap_with_mass

  real(dp), parameter :: pi = acos(-1.0_dp)

contains

  pure function overlap_with_mass(loaded, free, amplitude) result(sums)
    !! Σ_i (∫Φ̄_kφ_i dξ + γΦ̄_k(1)φ_i(1)) a_i: Eq. 26 times M̄_k.
    !! **Errors**: within 1e-13 of the sum of the terms' magnitudes.
    type(closed_form_set), intent(in) :: loaded   !! modes Φ̄_k with the mass
    type(closed_form_set), intent(in) :: free     !! modes φ_i without it, γ = 0
    real(dp), intent(in) :: amplitude(:)          !! a_i, (free%count)
    real(dp) :: sums(loaded%count)
    sums = weighted_sums(loaded, free, amplitude*free%alpha**4, own=amplitude)
  end function overlap_with_mass

  pure function overlap_of_beam(loaded, free, amplitude) result(sums)
    !! Σ_i ∫Φ̄_kφ_i dξ a_i: the beam's part alone.
    type(closed_form_set), intent(in) :: loaded
    type(closed_form_set), intent(in) :: free
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(loaded%count)
    sums = loaded%alpha**4*weighted_sums(loaded, free, amplitude, own=amplitude/free%alpha**4)
  end function overlap_of_beam

  pure function weighted_sums(loaded, free, weight, own) result(sums)
    !! γΦ̄_k(1) Σ_i φ_i(1) w_i/(α_i⁴ − ᾱ_k⁴); without a mass the limit is own_k, the term i = k alone.
    type(closed_form_set), intent(in) :: loaded, free
    real(dp), intent(in) :: weight(:), own(:)
    real(dp) :: sums(loaded%count)
    integer :: k, common
    if (loaded%gamma == 0.0_dp) then
      common = min(loaded%count, free%count)
      sums = 0.0_dp
      sums(:common) = own(:common)
      return
    end if
    do k = 1, loaded%count
      sums(k) = loaded%shape(k)%tip_force/loaded%alpha(k) &
        *accurate_sum(free%tip*weight/differences(loaded, free, k))
    end do
  end function weighted_sums

  pure function differences(loaded, free, k) result(values)
    !! α_i⁴ − ᾱ_k⁴ for all i.
    type(closed_form_set), intent(in) :: loaded, free
    integer, intent(in) :: k
    real(dp) :: values(free%count)
    associate (bar => loaded%shape(k)%root, alpha_bar => loaded%alpha(k), root => free%shape%root)
      values = (0.25_dp*pi*(root%eighths - bar%eighths) + (root%rest - bar%rest)) &
        *(free%alpha + alpha_bar)*(free%alpha**2 + alpha_bar**2)
      if (k <= free%count) values(k) = fourth_power_difference(root(k), bar)
    end associate
  end function differences

end module bw_overlap
