module bw_refined_root
  !! Roots of the frequency equation to about 30 digits: one Newton step with the residual in extended precision, from
  !! the exact mass ratio, only for modes that need it. Far modes, with sech α and 1 − tanh α below that precision, are
  !! refined many at a time in vector registers, in double-double; the first few in binary128, which runs in software.
  !!
  !! Sines of binary64 angles in double-double are power series in an eighth of the angle, followed three times by sin
  !! 2y = 2 sin y (1 − v), 1 − cos 2y = 2 sin² y, with v = 1 − cos y in place of the cosine: near 0 it keeps the digits
  !! that 1 − v would lose. Errors are below 1e-31, absolutely.
  use bw_constants, only: qp_pi
  use bw_double_double, only: dd, to_dd, to_quad, operator(*), operator(+), operator(-), operator(/)
  use bw_frequency_equation, only: first_slope, is_light, root_type
  use bw_kinds, only: dp, qp
  use bw_mode_set, only: least_phase, near_critical
  implicit none (type, external)
  private
  public :: is_coarse, refine_roots, refined_root, sine_and_versine

  integer, parameter :: first_far = 25               !! first mode with sech α below 2e-33

  integer, parameter :: doublings = 3
  integer, parameter :: long_terms = 4   !! beyond the first: binary64 is not enough for these
  integer, parameter :: all_terms = 8    !! beyond the first: at y = 1/8 the next is below 1e-33 of the sum

  real(qp), parameter :: sine_terms(all_terms) = 1.0_qp/[-6.0_qp, 120.0_qp, -5040.0_qp, 362880.0_qp, -39916800.0_qp, &
    6227020800.0_qp, -1307674368000.0_qp, 355687428096000.0_qp]              !! ±1/(2m+1)!
  real(qp), parameter :: versine_terms(all_terms) = 2.0_qp/[-24.0_qp, 720.0_qp, -40320.0_qp, 3628800.0_qp, -479001600.0_qp, &
    87178291200.0_qp, -20922789888000.0_qp, 6402373705728000.0_qp]           !! ±2/(2m+2)!

contains

  elemental logical function is_coarse(remainder, alpha, omega, longest) result(coarse)
    !! Return whether a root needs extended precision; only such roots are refined.
    real(dp), intent(in) :: remainder, alpha           !! of the root
    type(dd), intent(in), optional :: omega       !! in-plane angular velocity in h/l²; absent: none
    real(dp), intent(in), optional :: longest     !! duration of the history in l²/h; absent: none
    real(dp) :: drift
    coarse = .false.
    if (present(omega)) coarse = abs(alpha**2 - omega%hi) < near_critical*alpha**2
    if (.not. present(longest)) return
    drift = alpha*(remainder*epsilon(drift))*longest      ! of the phase: 2αδα t, δα half a unit of `remainder`
    coarse = coarse .or. abs(drift) > least_phase
  end function is_coarse

  pure subroutine refine_roots(root, coarse, alpha)
    !! Refine α of coarse roots in extended precision; a few hundred at a time.
    type(root_type), intent(in) :: root(:)        !! of one mass ratio
    logical, intent(in) :: coarse(:)              !! (roots)
    type(dd), intent(inout) :: alpha(:)           !! in binary64, then refined, (roots)
    logical :: far(size(root))
    integer :: i
    do i = 1, size(root)
      far(i) = coarse(i) .and. root(i)%k >= first_far
      if (coarse(i) .and. .not. far(i)) alpha(i) = refined_root(root(i))
    end do
    if (.not. any(far)) return
    call refine_far(root, far .and. is_light(root), .true., alpha)
    call refine_far(root, far .and. .not. is_light(root), .false., alpha)
  end subroutine refine_roots

  pure subroutine refine_far(root, chosen, light, alpha)
    !! Refine chosen far roots.
    type(root_type), intent(in) :: root(:)
    logical, intent(in) :: chosen(:), light       !! all chosen ones are light, or none
    type(dd), intent(inout) :: alpha(:)
    type(dd) :: batch(count(chosen))
    real(dp) :: remainder(size(batch))
    if (size(batch) == 0) return
    batch = pack(alpha, chosen)
    remainder = pack(root%remainder, chosen)
    if (light) then
      call refine_light(mass_ratio(root(1)), remainder, batch)
    else
      call refine_heavy(mass_ratio(root(1)), remainder, batch)
    end if
    alpha = unpack(batch, chosen, alpha)
  end subroutine refine_far

  elemental type(dd) function mass_ratio(root)
    !! Return γ to all digits.
    type(root_type), intent(in) :: root
    mass_ratio = dd(root%gamma, root%gamma_low)
  end function mass_ratio

  ! In double-double numbers

  pure subroutine refine_light(gamma, remainder, alpha)
    !! Take one Newton step of sin δ (1 + c) + c cos δ = 0, c = γα, at α = (k − ½)π + δ.
    type(dd), intent(in) :: gamma
    real(dp), intent(in) :: remainder(:)               !! δ in binary64, (modes)
    type(dd), intent(inout) :: alpha(:)           !! the same with its anchor; refined
    type(dd), dimension(size(remainder)) :: sine, versine, c, residual
    real(dp), dimension(size(remainder)) :: cosine, slope
    call sine_and_versine(remainder, sine, versine)
    c = alpha*gamma
    residual = sine + c*(sine - versine + to_dd(1.0_dp))
    cosine = 1.0_dp - versine%hi
    slope = cosine + c%hi*(cosine - sine%hi) + gamma%hi*(sine%hi + cosine)
    alpha = alpha + (-(residual%hi/slope))
  end subroutine refine_light

  pure subroutine refine_heavy(gamma, remainder, alpha)
    !! Take one Newton step of sin δ (2 + u) − u cos δ = 0, u = 1/(γα), at α = (k − ¾)π + δ.
    type(dd), intent(in) :: gamma
    real(dp), intent(in) :: remainder(:)               !! see `refine_light`
    type(dd), intent(inout) :: alpha(:)
    real(dp), parameter :: heaviest = 1.0e40_dp   ! beyond it δ is below 1e-42, and γα soon overflows
    type(dd), dimension(size(remainder)) :: sine, versine, u, residual
    real(dp), dimension(size(remainder)) :: cosine, slope
    type(dd) :: mass
    mass = gamma
    if (gamma%hi > heaviest) mass = to_dd(heaviest)
    call sine_and_versine(remainder, sine, versine)
    u = to_dd(1.0_dp)/(alpha*mass)
    residual = sine*2.0_dp + u*(sine + versine - to_dd(1.0_dp))
    cosine = 1.0_dp - versine%hi
    slope = cosine*(2.0_dp + u%hi) + u%hi*sine%hi - (u%hi/alpha%hi)*(sine%hi - cosine)
    alpha = alpha + (-(residual%hi/slope))
  end subroutine refine_heavy

  ! In binary128

  elemental type(dd) function refined_root(root) result(alpha)
    !! Return α of any root, in binary128. The step squares the relative error of the binary64 root, about 1e-16.
    type(root_type), intent(in) :: root
    if (root%k == 1) then
      alpha = to_dd(refined_first(root))
    else
      alpha = to_dd(refined_higher(root))
    end if
  end function refined_root

  elemental real(qp) function refined_first(root) result(alpha)
    !! Return one Newton step of 1 + cos α cosh α − 4γxT₃(x) = 0 in x = α⁴, divided by γ for γ > 1 (see bw_frequency_equation).
    type(root_type), intent(in) :: root
    real(qp) :: x, free, mass
    x = real(root%remainder, qp)**4
    free = 1.0_qp/max(1.0_qp, to_quad(mass_ratio(root)))
    mass = min(1.0_qp, to_quad(mass_ratio(root)))
    x = x - (free*(1.0_qp + series(0, x)) - 4.0_qp*mass*x*series(3, x))/first_slope(root%gamma, real(x, dp))
    alpha = sqrt(sqrt(x))
  end function refined_first

  elemental real(qp) function series(j, x) result(sum)
    !! Return T_j(x) = Σ(−4x)^m/(4m+j)!, summed to convergence.
    integer, intent(in) :: j
    real(qp), intent(in) :: x
    real(qp) :: term
    integer :: m, n
    term = 1.0_qp/gamma(real(j + 1, qp))
    sum = term
    do m = 1, 20
      n = 4*m + j
      term = -4.0_qp*x*term/(real(n, qp)*(n - 1)*(n - 2)*(n - 3))
      sum = sum + term
    end do
  end function series

  elemental real(qp) function refined_higher(root) result(alpha)
    !! Return one Newton step of sech α + cos α + γα(cos α tanh α − sin α) = 0, divided by γα if that is above 1.
    type(root_type), intent(in) :: root
    real(qp) :: c, difference, free, mass, sum
    alpha = 0.25_qp*root%eighths*qp_pi + root%remainder
    c = alpha*to_quad(mass_ratio(root))
    free = 1.0_qp/max(1.0_qp, c)
    mass = min(1.0_qp, c)
    sum = secant(alpha) + cos(alpha)
    difference = cos(alpha)*tanh(alpha) - sin(alpha)
    alpha = alpha - (free*sum + mass*difference) &
      /(free*(merge(difference*c, -sum, c <= 1.0_qp)/alpha - sin(alpha) - secant(alpha)*tanh(alpha)) &
        + mass*(cos(alpha)*(secant(alpha)**2 - 1.0_qp) - sin(alpha)*tanh(alpha)))
  end function refined_higher

  elemental real(qp) function secant(alpha)
    !! Return sech α without overflow.
    real(qp), intent(in) :: alpha
    secant = 2.0_qp*exp(-alpha)/(1.0_qp + exp(-2.0_qp*alpha))
  end function secant


  pure subroutine sine_and_versine(angle, sine, versine)
    !! Compute sin x and 1 − cos x.
    real(dp), intent(in) :: angle(:)             !! x, |x| ≤ 1
    type(dd), intent(out) :: sine(:), versine(:) !! (size(angle))
    type(dd), dimension(size(angle)) :: part, square
    integer :: i
    part%hi = angle/2.0_dp**doublings
    part%lo = 0.0_dp
    square = part*part
    sine = part*sine_series(square, sine_terms)
    versine = (square*sine_series(square, versine_terms))*0.5_dp
    do i = 1, doublings
      part = sine*versine
      versine = (sine*sine)*2.0_dp
      sine = (sine - part)*2.0_dp
    end do
  end subroutine sine_and_versine

  pure function sine_series(square, terms) result(sum)
    !! Return 1 + Σ_m terms_m·square^m, with the last terms in binary64.
    type(dd), intent(in) :: square(:)
    real(qp), intent(in) :: terms(all_terms)
    type(dd) :: sum(size(square))
    real(dp) :: tail(size(square)), short(all_terms)
    integer :: m
    short = real(terms, dp)
    tail = short(all_terms)
    do m = all_terms - 1, long_terms + 1, -1
      tail = short(m) + square%hi*tail
    end do
    sum = dd(short(long_terms), real(terms(long_terms) - short(long_terms), dp)) + square%hi*tail
    do m = long_terms - 1, 1, -1
      sum = sum*square + dd(short(m), real(terms(m) - short(m), dp))
    end do
    sum = sum*square + dd(1.0_dp, 0.0_dp)
  end function sine_series

end module bw_refined_root
