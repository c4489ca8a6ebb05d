module bw_piece_products
  !! Integrals over a piece of the product of two motions at two frequencies, weighted by its mass and rotary inertia.
  !!
  !! At distant frequencies the states at the ends give it: (λ' − λ)∫ρAvv' + ρIψψ' dx is the difference of v'N + ψ'M −
  !! vN' − ψM' between the ends, with N and M of one, N' and M' of the other motion. At close frequencies the waves are
  !! integrated in pairs. For C and S at z and z', ∫CC' dx = 2(zSC' − z'CS')/(z − z') and ∫SS' dx = 2(SC' − CS')/(z −
  !! z') at the end; two waves of one kind use sums and differences of their wave numbers instead, p = √|z|, as the
  !! difference may vanish. Slowly varying products use Gauss quadrature.
  use bw_double_double, only: dd, operator(+), operator(-), operator(*)
  use bw_kinds, only: dp
  use bw_piece_shape, only: states_inside, wave_values
  use bw_piece_waves, only: circular, is_short, piece_frequency, piece_numbers, wave_numbers, wave_numbers_of
  implicit none (type, external)
  private
  public :: part_of, piece_product, turn_product

  integer, parameter :: nodes = 20
  real(dp), parameter :: half_rule(10) = [ &
    0.99312859918509492479_dp, 0.96397192727791379127_dp, 0.91223442825132590587_dp, 0.83911697182221882339_dp, &
    0.74633190646015079261_dp, 0.63605368072651502545_dp, 0.510867001950827098_dp, 0.37370608871541956067_dp, &
    0.22778585114164507808_dp, 0.076526521133497333755_dp]    !! positive Gauss nodes on −1 … 1
  real(dp), parameter :: half_weights(10) = [ &
    0.017614007139152118312_dp, 0.040601429800386941331_dp, 0.06267204833410906357_dp, 0.083276741576704748725_dp, &
    0.10193011981724043504_dp, 0.11819453196151841731_dp, 0.1316886384491766269_dp, 0.14209610931838205133_dp, &
    0.14917298647260374679_dp, 0.1527533871307258507_dp]
  real(dp), parameter :: node(nodes) = [half_rule, -half_rule], gauss(nodes) = [half_weights, half_weights]
  real(dp), parameter :: calm = 4.0_dp           !! |z|h² up to which products of C and of S use Gauss quadrature
  real(dp), parameter :: far = 0.1_dp            !! relative difference of λ above which end states give all digits

  type, public :: piece_part
    !! The motion of one piece.
    type(piece_frequency) :: frequency
    type(wave_numbers) :: waves                  !! unless the piece is short
    real(dp) :: amplitude(4) = 0.0_dp
    real(dp) :: ends(4, 2) = 0.0_dp              !! states at its inner and its outer end
    logical :: short = .false.
  end type piece_part

contains

  pure type(piece_part) function part_of(piece, frequency, amplitude) result(part)
    !! Return the data of a motion for products.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(in) :: amplitude(4)
    part%frequency = frequency
    part%amplitude = amplitude
    part%ends = states_inside(piece, frequency, amplitude, [-piece%half, piece%half])
    part%short = is_short(piece, frequency)
    if (.not. part%short) part%waves = wave_numbers_of(piece, frequency)
  end function part_of

  pure real(dp) function piece_product(piece, one, other) result(product)
    !! Return ∫ρAvv' + ρIψψ' dx of two motions.
    type(piece_numbers), intent(in) :: piece
    type(piece_part), intent(in) :: one, other
    type(dd) :: gap
    gap = one%frequency%lambda - other%frequency%lambda
    if (abs(gap%hi) > far*max(abs(one%frequency%lambda%hi), abs(other%frequency%lambda%hi))) then
      product = end_product(one%ends, other%ends)/(-gap%hi)
    else if (one%short .or. other%short) then
      product = gauss_product(piece, one%frequency, one%amplitude, other%frequency, other%amplitude)
    else
      product = wave_product(piece, one%waves, one%amplitude, other%waves, other%amplitude)
    end if
  end function piece_product

  pure real(dp) function turn_product(piece, frequency, amplitude, inner) result(product)
    !! Return ∫ρAxv + ρIψ dx of a motion and a rigid rotation about the root, by the end states: mλ∫xv = −[xN + M] −
    !! R∫ψ, ∫ψ = ([v] + s[M])/(1 − sR); by Gauss quadrature in a short piece, and over half waves where sR is near 1.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(in) :: amplitude(4)
    real(dp), intent(in) :: inner                !! position of the inner end
    real(dp), parameter :: near_cutoff = 1.0e-2_dp
    real(dp) :: cut, ends(4, 2), turned
    type(wave_numbers) :: waves
    integer :: halves, j
    cut = 1.0_dp - piece%cut%hi*frequency%rho%hi
    if (.not. is_short(piece, frequency) .and. abs(cut) > near_cutoff) then
      ends = states_inside(piece, frequency, amplitude, [-piece%half, piece%half])
      turned = ((ends(1, 2) - ends(1, 1)) + piece%flexible%hi/piece%stiffness%hi*(ends(3, 2) - ends(3, 1)))/cut
      product = -((inner + 2*piece%half%hi)*ends(4, 2) - inner*ends(4, 1) + ends(3, 2) - ends(3, 1) &
                  + piece%rotary%hi*frequency%rho%hi*turned)/frequency%lambda%hi + piece%rotary%hi*turned
      return
    end if
    halves = 1
    if (.not. is_short(piece, frequency)) then
      waves = wave_numbers_of(piece, frequency)
      halves = 1 + int(maxval(waves%p%hi)*piece%half%hi)
    end if
    product = 0.0_dp
    do j = 1, halves
      product = product + part_of_turn((2*j - 1 - halves)/real(halves, dp))
    end do
  contains
    pure real(dp) function part_of_turn(middle) result(part)
      real(dp), intent(in) :: middle             !! of a part, over half of the piece
      real(dp) :: state(4, nodes), x(nodes)
      x = middle + node/halves
      state = states_inside(piece, frequency, amplitude, piece%half*x)
      part = piece%half%hi/halves*sum((piece%mass%hi*(inner + piece%half%hi*(1.0_dp + x))*state(1, :) &
                                       + piece%rotary%hi*state(2, :))*gauss)
    end function part_of_turn
  end function turn_product

  pure real(dp) function end_product(first, second) result(product)
    !! Return the product of the states at both ends.
    real(dp), dimension(4, 2), intent(in) :: first, second
    product = dot_product(second(1:2, 2), first([4, 3], 2)) - dot_product(first(1:2, 2), second([4, 3], 2)) &
      - (dot_product(second(1:2, 1), first([4, 3], 1)) - dot_product(first(1:2, 1), second([4, 3], 1)))
  end function end_product

  pure real(dp) function gauss_product(piece, one, amplitude, other, weight) result(product)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: one, other
    real(dp), intent(in) :: amplitude(4), weight(4)
    real(dp), dimension(4, nodes) :: first, second
    first = states_inside(piece, one, amplitude, piece%half*node)
    second = states_inside(piece, other, weight, piece%half*node)
    product = piece%half%hi*sum((piece%mass%hi*first(1, :)*second(1, :) + piece%rotary%hi*first(2, :)*second(2, :))*gauss)
  end function gauss_product

  pure real(dp) function wave_product(piece, one, amplitude, other, weight) result(product)
    type(piece_numbers), intent(in) :: piece
    type(wave_numbers), intent(in) :: one, other
    real(dp), intent(in) :: amplitude(4), weight(4)
    real(dp) :: cc, ss, odd(2), odd_too(2)
    integer :: i, j
    odd = amplitude(3:4)/sqrt(abs(one%y%hi))
    odd_too = weight(3:4)/sqrt(abs(other%y%hi))
    product = 0.0_dp
    do j = 1, 2
      do i = 1, 2
        call pair(one%z(i), one%p(i), other%z(j), other%p(j), piece%half, cc, ss)
        product = product + piece%mass%hi*(amplitude(i)*weight(j)*cc + odd(i)*one%z(i)%hi*odd_too(j)*other%z(j)%hi*ss)
        product = product + piece%rotary%hi*one%y(i)%hi*other%y(j)%hi*(amplitude(i)*weight(j)*ss + odd(i)*odd_too(j)*cc)
      end do
    end do
  end function wave_product

  pure subroutine pair(z, p, z_too, p_too, half, cc, ss)
    !! Find ∫CC' dx and ∫SS' dx, with C and S scaled as in `wave_values`.
    type(dd), intent(in) :: z, p, z_too, p_too, half
    real(dp), intent(out) :: cc, ss
    real(dp) :: c, s, c_too, s_too, sum, difference
    integer :: i
    if (max(abs(z%hi), abs(z_too%hi))*half%hi**2 < calm) then
      cc = 0.0_dp
      ss = 0.0_dp
      do i = 1, nodes
        call wave_values(z, p, half, half*node(i), c, s)
        call wave_values(z_too, p_too, half, half*node(i), c_too, s_too)
        cc = cc + half%hi*gauss(i)*c*c_too
        ss = ss + half%hi*gauss(i)*s*s_too
      end do
    else if ((z%hi > 0.0_dp) .neqv. (z_too%hi > 0.0_dp)) then
      call wave_values(z, p, half, half, c, s)
      call wave_values(z_too, p_too, half, half, c_too, s_too)
      cc = 2.0_dp*(z%hi*s*c_too - z_too%hi*c*s_too)/(z%hi - z_too%hi)
      ss = 2.0_dp*(s*c_too - c*s_too)/(z%hi - z_too%hi)
    else
      if (z%hi > 0.0_dp) then
        sum = mean_cosine(p + p_too, half)
        difference = mean_cosine(p - p_too, half)
        cc = difference + sum
        ss = (difference - sum)/(p%hi*p_too%hi)
      else
        call exponential_pair(p%hi, p_too%hi, (p%hi - p_too%hi) + (p%lo - p_too%lo), half%hi, cc, ss)
      end if
    end if
  end subroutine pair

  pure real(dp) function mean_cosine(p, half) result(integral)
    !! Return ∫cos px dx over half of the piece.
    type(dd), intent(in) :: p, half
    type(dd) :: angle
    real(dp) :: c, s
    angle = p*half
    if (abs(angle%hi) < 1.0e-8_dp) then
      integral = half%hi
    else
      call circular(angle, c, s)
      integral = s/p%hi
    end if
  end function mean_cosine

  elemental subroutine exponential_pair(q, q_too, gap, half, cc, ss)
    !! Find ∫cosh qx cosh q'x dx and ∫sinh qx sinh q'x dx/(qq') over cosh qh cosh q'h.
    real(dp), intent(in) :: q, q_too
    real(dp), intent(in) :: gap                  !! q − q'
    real(dp), intent(in) :: half
    real(dp), intent(out) :: cc, ss
    real(dp) :: small, large, scale, e, e_too
    e = exp(-2.0_dp*q*half)
    e_too = exp(-2.0_dp*q_too*half)
    scale = 2.0_dp/((1.0_dp + e)*(1.0_dp + e_too))
    large = (1.0_dp - e*e_too)/(q + q_too)
    if (abs(gap)*half < 1.0e-3_dp) then          ! sinh gh/g, next to 1
      small = 2.0_dp*half*exp(-(q + q_too)*half)*(1.0_dp + (gap*half)**2/6.0_dp + (gap*half)**4/120.0_dp)
    else
      small = (e_too - e)/gap
    end if
    cc = scale*(large + small)
    ss = scale*(large - small)/(q*q_too)
  end subroutine exponential_pair

end module bw_piece_products
