module bw_far_runs
  !! Runs of neighbouring far modes of a heavy mass: what changes slowly from mode to mode is sampled at some of them and
  !! interpolated. It halves the time of a sum over millions of modes.
  !!
  !! With A = (k − ¾)π these are β − A², δ = α − A, and the sizes of Φ(1) and Φ(1)/M, all of them analytic in k but near
  !! k = 0: a polynomial through the values at a few modes near Chebyshev's points is off by rounding alone in a run that
  !! begins far enough from there, and the farther it begins the fewer are enough. β − A² hardly changes within a run, so it is
  !! the change that is interpolated: phases keep the digits of the sampled roots, which may be extended ones.
  !!
  !! **Errors**: 2e-15 relatively, of β as `is_coarse` demands.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, rounder, two_products, operator(*), operator(-)
  use bw_far_modes, only: far_beam, far_frequencies, far_shapes_and_roots, light_modes
  use bw_refined_root, only: is_coarse
  implicit none (type, external)
  private
  public :: is_far_run, far_run_terms

  integer, parameter, public :: run_length = 256         !! tuned: modes of a run
  integer, parameter :: most = 12, least = 8             ! modes of it that are sampled; multiples of `together`
  integer, parameter :: lowest = 1024                    ! from here on `most` are enough
  integer, parameter :: distant = 6144                   ! and `least` from here on
  integer, parameter :: highest = 2**24                  ! up to here (4k − 3)² is exact in binary64
  integer, parameter :: places(most) = [144, 1, 254, 50, 205, 79, 229, 10, 176, 26, 245, 111]
    !! of the sampled modes, from 0; in Leja's order, in which the first of them serve too, and Newton's divided differences
    !! are stable
  integer, parameter :: together = 4                     ! powers of a polynomial
  real(dp), parameter :: half_run = 0.5_dp*run_length, middle_place = half_run - 0.5_dp
  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: slow_turning = 0.01_dp          ! of α²: a faster rotation brings the root of α⁴ − ω² too near
  integer, parameter :: excess = 1, drives = 2, tips = 3, remainders = 4   ! rows of what is interpolated

contains

  pure logical function is_far_run(k, beam, xi)
    !! Whether the modes may be found by `far_run_terms`.
    integer, intent(in) :: k(:)                !! ascending
    type(far_beam), intent(in) :: beam
    real(dp), intent(in) :: xi(:)              !! points
    real(dp) :: nearest
    is_far_run = .false.
    if (size(k) /= run_length .or. k(1) < lowest .or. k(size(k)) /= k(1) + run_length - 1 .or. k(size(k)) > highest) return
    if (.not. allocated(beam%longest)) return                        ! only sums of histories have so many
    if (light_modes(k(:1), beam%gamma%hi) == 1) return
    if (allocated(beam%omega)) then
      if (abs(beam%omega%hi) > slow_turning*((k(1) - 0.75_dp)*pi)**2) return
    end if
    nearest = 1.0_dp/lowest                                          ! else e^(−αξ) counts there, or e^(−α(1−ξ))
    is_far_run = all(xi == 0.0_dp .or. xi == 1.0_dp .or. (xi > 16*nearest .and. 1.0_dp - xi > 16*nearest))
  end function is_far_run

  pure subroutine far_run_terms(first, beam, xi, beta, drive, shapes, found)
    !! Find the `far_terms` of the modes of a run.
    integer, intent(in) :: first                         !! number of the first mode
    type(far_beam), intent(in) :: beam
    real(dp), intent(in) :: xi(:)
    type(dd), intent(out) :: beta(run_length)
    real(dp), intent(out) :: drive(run_length), shapes(:, :)
    logical, intent(out) :: found                        !! false: phases would not be right for so long
    real(dp) :: eighths(run_length), values(run_length, 4), sampled(4, most), sign_of
    type(dd) :: middle
    integer :: j, n, p
    n = merge(least, most, first >= distant)
    sign_of = merge(1.0_dp, -1.0_dp, mod(first, 2) == 0)
    call sample(first, places(:n), beam, middle, sampled(:, :n))
    found = .not. is_coarse(maxval(abs(sampled(excess, :n))), 1.0_dp, longest=beam%longest)
    if (.not. found) return
    call interpolate(n, sampled(:, :n), values)
    values(1::2, drives:tips) = sign_of*values(1::2, drives:tips)
    values(2::2, drives:tips) = -sign_of*values(2::2, drives:tips)
    eighths = [(4*(first + j) - 3, j=0, run_length - 1)]
    call add_squares(eighths, middle, values(:, excess), beta)
    drive = values(:, drives)
    do p = 1, size(xi)
      if (xi(p) == 0.0_dp .or. xi(p) == 1.0_dp) then
        shapes(:, p) = xi(p)*values(:, tips)
      else
        call inner_shapes(eighths, values(:, remainders), xi(p), shapes(:, p))
      end if
    end do
  end subroutine far_run_terms

  pure subroutine sample(first, place, beam, middle, sampled)
    !! Find what is interpolated, at the modes that are sampled.
    integer, intent(in) :: first
    integer, intent(in) :: place(:)                      !! of them in the run, from 0, (n)
    type(far_beam), intent(in) :: beam
    type(dd), intent(out) :: middle                      !! β − A² of the first of them, which others add to
    real(dp), intent(out) :: sampled(:, :)               !! (quantities, n), sizes without signs
    real(dp) :: remainder(size(place)), drive(size(place)), tip(size(place), 1)
    type(dd) :: alpha(size(place)), beta(size(place))
    integer :: j
    call far_shapes_and_roots(first + place, beam%gamma%hi, [1.0_dp], remainder, alpha, drive, tip)
    call far_frequencies(first + place, beam, remainder, alpha, beta)
    beta = beta - squares(4.0_dp*(first + place) - 3.0_dp)
    middle = beta(1)
    do j = 1, size(place)
      beta(j) = beta(j) - middle
      sampled(excess, j) = beta(j)%hi
      sampled(drives:tips, j) = [drive(j), tip(j, 1)]*merge(1.0_dp, -1.0_dp, mod(first + place(j), 2) == 0)
      sampled(remainders, j) = remainder(j)
    end do
  end subroutine sample

  pure subroutine interpolate(n, sampled, values)
    !! Evaluate the polynomials through the sampled values at all modes of a run.
    integer, intent(in) :: n                             !! of them
    real(dp), intent(in) :: sampled(4, n)                !! (quantities, n)
    real(dp), intent(out) :: values(run_length, 4)       !! (run, quantities)
    real(dp) :: p(4, 0:n - 1), x(run_length)
    integer :: j, k, q
    call find_powers(n, sampled, p)
    x = [((k - middle_place)/half_run, k=0, run_length - 1)]
    values = 0.0_dp
    do q = 1, 4
      do j = n - together, 0, -together
        do k = 1, run_length       ! Horner's rule is written out: as a loop it keeps this one out of vector registers
          values(k, q) = (((values(k, q)*x(k) + p(q, j + 3))*x(k) + p(q, j + 2))*x(k) + p(q, j + 1))*x(k) + p(q, j)
        end do
      end do
    end do
  end subroutine interpolate

  pure subroutine find_powers(n, sampled, p)
    !! Find Newton's divided differences, and from them the coefficients of powers of the place in the run, −1 … 1: from far off
    !! as runs are from where quantities vary fast, they fall so quickly that powers are as good as any polynomials.
    integer, intent(in) :: n
    real(dp), intent(in) :: sampled(4, n)
    real(dp), intent(out) :: p(4, 0:n - 1)
    real(dp) :: c(4, n)
    integer :: i, j
    c = sampled
    do j = 1, n - 1
      do i = n, j + 1, -1
        c(:, i) = (c(:, i) - c(:, i - 1))*(half_run/(places(i) - places(i - j)))
      end do
    end do
    p = 0.0_dp
    p(:, 0) = c(:, n)
    do i = n - 1, 1, -1
      do j = n - i, 1, -1
        p(:, j) = p(:, j - 1) - ((places(i) - middle_place)/half_run)*p(:, j)
      end do
      p(:, 0) = c(:, i) - ((places(i) - middle_place)/half_run)*p(:, 0)
    end do
  end subroutine find_powers

  pure function squares(eighths) result(square)
    !! A², A = eighths·π/4.
    real(dp), intent(in) :: eighths(:)                   !! whole numbers below 2²⁶, whose squares are exact
    type(dd) :: square(size(eighths))
    square = square_of_eighth()*eighths**2
  end function squares

  pure type(dd) function square_of_eighth()
    !! (π/4)².
    square_of_eighth = dd_pi*dd_pi*0.0625_dp
  end function square_of_eighth

  pure subroutine add_squares(eighths, middle, change, beta)
    !! Add up β = A² + middle + change, of which each is far larger than the next.
    real(dp), intent(in) :: eighths(run_length), change(run_length)
    type(dd), intent(in) :: middle
    type(dd), intent(out) :: beta(run_length)
    real(dp), dimension(run_length) :: product, remainder
    type(dd) :: unit
    real(dp) :: high, low, small
    integer :: i
    unit = square_of_eighth()
    call two_products(eighths**2, unit%hi, product, remainder)
    do i = 1, run_length
      small = middle%hi + change(i)
      low = (change(i) - (small - middle%hi)) + middle%lo
      high = product(i) + small
      low = (small - (high - product(i))) + (low + (remainder(i) + eighths(i)**2*unit%lo))
      beta(i)%hi = high + low
      beta(i)%lo = low - (beta(i)%hi - high)
    end do
  end subroutine add_squares

  pure subroutine inner_shapes(eighths, remainder, xi, values)
    !! Find √2 cos(αξ + π/4): the whole eighths of a turn times either half of ξ are exact.
    real(dp), intent(in) :: eighths(run_length), remainder(run_length)      !! α = eighths·π/4 + remainder
    real(dp), intent(in) :: xi
    real(dp), intent(out) :: values(run_length)
    real(dp) :: angle(run_length), high, low, whole
    integer :: i
    high = aint(xi*2.0_dp**26)*2.0_dp**(-26)
    low = xi - high
    do i = 1, run_length
      whole = eighths(i)*high
      whole = whole - 8.0_dp*((0.125_dp*whole + rounder) - rounder)
      angle(i) = 0.25_dp*pi*(whole + (1.0_dp + eighths(i)*low)) + remainder(i)*xi
    end do
    values = sqrt(2.0_dp)*cos(angle)
  end subroutine inner_shapes

end module bw_far_runs
