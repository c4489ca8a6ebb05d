module bw_overlap
  !! Overlaps between two sets of modes in closed form: the sums of Eqs 23 and 26 without quadrature.
  !!
  !! The two-shape identity of v'''' = α⁴v gives, for a loaded shape Φ̄_k and a free one φ_i,
  !! ∫Φ̄_kφ_i dξ = Φ̄_k'''(1)φ_i(1)/(ᾱ_k⁴ − α_i⁴), Φ̄_k'''(1) = −γᾱ_k⁴Φ̄_k(1); with the mass's own term γΦ̄_k(1)φ_i(1)
  !! the sum is γΦ̄_k(1)φ_i(1) α_i⁴/(α_i⁴ − ᾱ_k⁴). So Eq. 26, and the way back when the mass leaves, come down to sums
  !! Σ_k w_k/(α_i⁴ − ᾱ_k⁴) over two sets of modes, one of the beam alone and one with the mass at its tip.
  !!
  !! For i = k and a light mass the two roots agree to all digits, so their difference is solved for directly. Few modes
  !! are summed pairwise. For many, distant pairs are summed by cells (bw_far_field), in time proportional to the number
  !! of modes, and only neighbours pairwise.
  use bw_constants, only: pi
  use bw_double_double, only: add_exactly, dd
  use bw_far_field, only: add_far_field, cells_to, first_in_cells
  use bw_frequency_equation, only: alternating_series, root_type, root_value
  use bw_kinds, only: dp, i8
  use bw_mode_set, only: batch
  use bw_monitor, only: between_questions, monitor_type, stops
  use bw_root_list, only: root_values
  use bw_shape, only: shape_type, shapes_of
  implicit none (type, external)
  private
  public :: overlap_with_tip_mass, overlap_without_mass, gap_sums
  public :: fourth_power_difference, pair_sums       ! for their own tests

  integer(i8), parameter, public :: most_pairs = 4000000_i8
    !! tuned: equal time pairwise and by cells, some ms

contains

  function overlap_with_tip_mass(loaded, free, amplitude, monitor) result(sums)
    !! Return Σ_i (∫Φ̄_kφ_i dξ + γΦ̄_k(1)φ_i(1)) a_i: Eq. 26 times M̄_k.
    !! **Errors**: within 1e-13 of the sum of the terms' magnitudes.
    type(root_type), intent(in) :: loaded(:)      !! of modes Φ̄_k with the mass, any
    type(root_type), intent(in) :: free(:)        !! of modes φ_i without it, γ = 0, from the first
    real(dp), intent(in) :: amplitude(:)          !! a_i, (size(free))
    class(monitor_type), intent(inout), optional :: monitor   !! the sums are invalid if it requests a stop
    real(dp) :: sums(size(loaded))
    if (carries_mass(loaded)) then
      sums = gap_sums(loaded, free, by_tip(free, 4, amplitude, .false.), .false., monitor)
      sums = by_tip(loaded, 0, -sums, .true.)
    else
      sums = own(loaded, amplitude)
    end if
  end function overlap_with_tip_mass

  function overlap_without_mass(onto, from, amplitude, monitor) result(sums)
    !! Return Σ_i a_i∫Φ_kφ_i dξ, without the mass.
    type(root_type), intent(in) :: onto(:)        !! of modes Φ_k, any; one of the two sets is without mass
    type(root_type), intent(in) :: from(:)        !! of modes φ_i, from the first
    real(dp), intent(in) :: amplitude(:)          !! a_i, (size(from))
    class(monitor_type), intent(inout), optional :: monitor   !! see above
    real(dp) :: sums(size(onto))
    if (carries_mass(from)) then
      sums = gap_sums(onto, from, by_tip(from, 4, amplitude, .true.), .true., monitor)
      sums = by_tip(onto, 0, sums, .false.)
    else if (carries_mass(onto)) then
      sums = gap_sums(onto, from, by_tip(from, 0, amplitude, .false.), .false., monitor)
      sums = by_tip(onto, 4, -sums, .true.)
    else
      sums = own(onto, amplitude)
    end if
  end function overlap_without_mass

  pure logical function carries_mass(root)
    !! Return whether the modes have the mass at the tip.
    type(root_type), intent(in) :: root(:)
    carries_mass = root(1)%gamma > 0.0_dp
  end function carries_mass

  pure function own(onto, amplitude) result(sums)
    !! Return the sums without mass: both sets are the same, and only the term i = k remains.
    type(root_type), intent(in) :: onto(:)
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(size(onto))
    integer :: k
    sums = 0.0_dp
    do k = 1, size(onto)
      if (onto(k)%k <= size(amplitude)) sums(k) = amplitude(onto(k)%k)
    end do
  end function own

  pure function by_tip(root, power, values, by_mass) result(products)
    !! Return Φ(1)α^power, or γΦ(1)α^power, times values.
    type(root_type), intent(in) :: root(:)
    integer, intent(in) :: power
    real(dp), intent(in) :: values(:)
    logical, intent(in) :: by_mass
    real(dp) :: products(size(root))
    type(shape_type) :: shape(batch)
    integer :: first, last
    do first = 1, size(root), batch
      last = min(first + batch - 1, size(root))
      associate (s => shape(:last - first + 1))
        s = shapes_of(root(first:last))
        if (by_mass) then
          products(first:last) = s%tip_force/s%alpha*values(first:last)*s%alpha**power
        else
          products(first:last) = s%tip*(values(first:last)*s%alpha**power)
        end if
      end associate
    end do
  end function by_tip


  function gap_sums(onto, from, weight, onto_free, monitor) result(sums)
    !! Return Σ_k w_k/(α_i⁴ − α_k⁴) for all i.
    !! **Errors**: within 1e-14 of the sum of the terms' magnitudes.
    type(root_type), intent(in) :: onto(:)           !! i, ascending
    type(root_type), intent(in) :: from(:)           !! k, ascending
    real(dp), intent(in) :: weight(:)                !! (size(from))
    logical, intent(in) :: onto_free                 !! `onto` are without the mass, else `from` are
    class(monitor_type), intent(inout), optional :: monitor   !! the sums are invalid if it requests a stop
    real(dp) :: sums(size(onto))
    integer :: first, last
    if (int(size(onto), i8)*size(from) > most_pairs) then
      sums = 0.0_dp
      call add_far_field(onto, from, weight, sums, monitor)
      call add_neighbours(onto, from, weight, onto_free, sums, monitor)
    else
      do first = 1, size(onto), batch
        last = min(first + batch - 1, size(onto))
        sums(first:last) = pair_sums(onto(first:last), from, weight, onto_free)
      end do
    end if
  end function gap_sums

  subroutine add_neighbours(onto, from, weight, onto_free, sums, monitor)
    !! Add the near field: pairs in one cell, or in two that touch.
    type(root_type), intent(in) :: onto(:), from(:)
    real(dp), intent(in) :: weight(:)
    logical, intent(in) :: onto_free
    real(dp), intent(inout) :: sums(:)
    class(monitor_type), intent(inout), optional :: monitor
    integer, allocatable :: here(:), there(:)
    integer :: c, cells, first, last
    cells = max(cells_to(onto), cells_to(from))
    allocate (here, source=first_in_cells(onto, cells))
    allocate (there, source=first_in_cells(from, cells))
    do c = 1, cells
      if (mod(c, between_questions) == 0) then
        if (stops(monitor)) return
        if (present(monitor)) call monitor%advance(real(c, dp)/cells)
      end if
      first = there(max(1, c - 1))
      last = there(min(cells, c + 1) + 1) - 1
      associate (i => here(c), j => here(c + 1) - 1)
        sums(i:j) = sums(i:j) + pair_sums(onto(i:j), from(first:last), weight(first:last), onto_free)
      end associate
    end do
  end subroutine add_neighbours

  pure function pair_sums(onto, from, weight, onto_free) result(sums)
    !! Return `gap_sums` pairwise, for all i at a time in vector registers, with compensated summation (Neumaier).
    type(root_type), intent(in) :: onto(:)           !! a few hundred
    type(root_type), intent(in) :: from(:)
    real(dp), intent(in) :: weight(:)
    logical, intent(in) :: onto_free
    real(dp) :: sums(size(onto))
    real(dp), dimension(size(onto)) :: eighths, alpha, square, gap, lost
    type(dd) :: value(max(size(onto), size(from)))
    integer :: i, k
    sums = 0.0_dp
    lost = 0.0_dp
    if (size(onto) == 0) return
    value(:size(onto)) = root_values(onto)
    alpha = value(:size(onto))%hi
    value(:size(from)) = root_values(from)
    eighths = onto%eighths
    square = alpha**2
    i = 1
    do k = 1, size(from)
      associate (other => from(k), other_alpha => value(k)%hi)
        gap = (0.25_dp*pi*(eighths - other%eighths) + (onto%remainder - other%remainder)) &
          *(alpha + other_alpha)*(square + other_alpha**2)
        do while (i < size(onto) .and. onto(i)%k < other%k)
          i = i + 1
        end do
        if (onto(i)%k == other%k) gap(i) = own_gap(onto(i), other, onto_free)
        call add_exactly(weight(k)/gap, sums, lost)
      end associate
    end do
    sums = sums + lost
  end function pair_sums

  elemental real(dp) function own_gap(onto, from, onto_free) result(gap)
    !! Return α⁴ − ᾱ⁴ of two modes with the same number, which may nearly agree.
    type(root_type), intent(in) :: onto, from
    logical, intent(in) :: onto_free
    if (onto_free) then
      gap = fourth_power_difference(onto, from)
    else
      gap = -fourth_power_difference(from, onto)
    end if
  end function own_gap

  elemental real(dp) function fourth_power_difference(free, loaded) result(difference)
    !! Return α⁴ − ᾱ⁴ for a root α of the beam alone (γ = 0) and a root ᾱ of the beam with a tip mass (γ ≥ 0). Zero only
    !! for the same k and γ = 0.
    type(root_type), intent(in) :: free    !! solves Eq. 8
    type(root_type), intent(in) :: loaded  !! solves Eq. 19
    real(dp) :: alpha, alpha_bar, drop
    type(dd) :: whole
    if (free%k == 1 .and. loaded%k == 1) then
      difference = first_drop(free%remainder**4, loaded)
      return
    end if
    whole = root_value(free)
    alpha = whole%hi
    whole = root_value(loaded)
    alpha_bar = whole%hi
    if (free%k == loaded%k .and. free%eighths == loaded%eighths) then
      drop = light_drop(free, loaded, alpha, alpha_bar)
    else
      drop = 0.25_dp*pi*(free%eighths - loaded%eighths) + (free%remainder - loaded%remainder)
    end if
    difference = drop*(alpha + alpha_bar)*(alpha**2 + alpha_bar**2)
  end function fourth_power_difference

  elemental real(dp) function first_drop(x_free, loaded) result(drop)
    !! Return y = x₀ − x of the first roots, x = α⁴: subtracting 1 + T₀(x₀) = 0 from 1 + T₀(x) = 4γxT₃(x) leaves y =
    !! −4γxT₃(x)/T₀[x, x₀] with the divided difference of T₀, a sum of terms of like sign.
    real(dp), intent(in) :: x_free
    type(root_type), intent(in) :: loaded
    real(dp) :: x, term, powers, divided
    integer :: m
    integer, parameter :: last_term = 8     ! of the series in bw_frequency_equation, for differences
    x = loaded%remainder**4
    powers = 1.0_dp                         ! Σ_j x^j x₀^(m−1−j)
    term = -1.0_dp/6.0_dp                   ! (−4)^m/(4m)!
    divided = term
    do m = 2, last_term
      powers = powers*x_free + x**(m - 1)
      term = -4.0_dp*term/real(4*m*(4*m - 1)*(4*m - 2)*(4*m - 3), dp)
      divided = divided + term*powers
    end do
    drop = -4.0_dp*loaded%gamma*x*alternating_series(3, x)/divided
  end function first_drop

  elemental real(dp) function light_drop(free, loaded, alpha, alpha_bar) result(drop)
    !! Return d = α_k − ᾱ_k, both anchored at (k − ½)π, by subtracting the two equations for δ: 2 sin(d/2) [cos(δ_m) −
    !! (−1)^k (sinh(d/2)/sin(d/2)) sinh α_m/(cosh α cosh ᾱ)] = ᾱγ (sin δ̄ tanh ᾱ + cos δ̄), with the means δ_m and α_m.
    !! The ratio of sines is 1 + O(d²), for which the plain difference suffices.
    type(root_type), intent(in) :: free, loaded
    real(dp), intent(in) :: alpha, alpha_bar
    real(dp) :: half, ratio, mean, sech, sign, mass_term
    half = 0.5_dp*(free%remainder - loaded%remainder)
    ratio = 1.0_dp
    if (half > 0.0_dp) ratio = sinh(half)/sin(half)
    mean = 0.5_dp*(alpha + alpha_bar)
    sign = merge(1.0_dp, -1.0_dp, mod(free%k, 2) == 0)
    sech = 2.0_dp*exp(-mean)*(1.0_dp - exp(-2.0_dp*mean)) &
      /((1.0_dp + exp(-2.0_dp*alpha))*(1.0_dp + exp(-2.0_dp*alpha_bar)))
    mass_term = alpha_bar*loaded%gamma*(sin(loaded%remainder)*tanh(alpha_bar) + cos(loaded%remainder))
    drop = 2.0_dp*asin(0.5_dp*mass_term/(cos(0.5_dp*(free%remainder + loaded%remainder)) - sign*ratio*sech))
  end function light_drop

end module bw_overlap
