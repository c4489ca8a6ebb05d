module bw_missing_samples
  !! Missing samples in white rows: the part of each row that no values of theirs explain.
  !!
  !! A missing sample g is an additional unknown in the p + 1 rows that it enters, by h_i in row g − i. White rows minus their
  !! projection onto all such columns C give the exact likelihood of the remaining samples, as if the noise between them were
  !! interpolated. Lines are projected in the same way.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: factorise, fills_of, find_reach, missing_among, solve, project_out_missing

  real(dp), parameter :: dependent = 1.0e-10_dp  !! of a column's square: a smaller part independent of earlier columns is rounding
  real(dp), parameter :: rounding = 1.0e-13_dp   !! of a column's square: uncertainty of sums of products

  type, public :: missing_type
    !! The missing samples that enter some rows, which are counted from 1.
    integer :: rows = 0
    integer, allocatable :: place(:)         !! ascending
    real(dp), allocatable :: filter(:)       !! h times any factor, (0:p)
    real(dp), allocatable :: root(:, :)      !! L of LLᵀ = CᵀC: L(j + k, j), (0:band, j)
  end type missing_type

contains

  pure function missing_among(places, first, rows, filter) result(missing)
    !! Select the missing samples that enter `rows` rows from the first one on.
    integer, intent(in) :: places(:)         !! ascending
    integer, intent(in) :: first, rows
    real(dp), intent(in) :: filter(0:)
    type(missing_type) :: missing
    real(dp) :: correlation(0:ubound(filter, 1))
    integer :: p, d, j, k, band, low
    p = ubound(filter, 1)
    missing%rows = rows
    missing%place = pack(places, places >= first .and. places < first + rows + p) - first + 1
    allocate (missing%filter(0:p), source=filter)
    correlation = [(dot_product(filter(:p - d), filter(d:)), d=0, p)]
    associate (g => missing%place)
      band = 0
      j = 1
      do k = 2, size(g)
        do while (g(k) - g(j) > p)
          j = j + 1
        end do
        band = max(band, k - j)
      end do
      allocate (missing%root(0:band, size(g)), source=0.0_dp)
      do j = 1, size(g)
        do k = 0, min(band, size(g) - j)
          d = g(j + k) - g(j)
          if (d > p) exit
          if (g(j) > p .and. g(j) <= rows) then
            missing%root(k, j) = correlation(d)
          else
            low = max(0, g(j) - rows)
            missing%root(k, j) = dot_product(filter(low:min(p - d, g(j) - 1)), filter(low + d:min(p - d, g(j) - 1) + d))
          end if
        end do
      end do
    end associate
    call factorise(missing%root, bounded=.false.)
  end function missing_among

  pure subroutine factorise(l, bounded)
    !! Replace a symmetric band matrix by its Cholesky factor, both as (0:band, columns). A column that depends on earlier ones is
    !! no unknown; with `bounded` it is one, to within rounding.
    real(dp), intent(inout) :: l(0:, :)
    logical, intent(in) :: bounded
    real(dp) :: square
    integer :: j, k, d, band
    band = ubound(l, 1)
    do j = 1, size(l, 2)
      square = l(0, j)
      do d = 1, min(band, j - 1)
        do k = 0, band - d
          l(k, j) = l(k, j) - l(d + k, j - d)*l(d, j - d)
        end do
      end do
      if (bounded .or. l(0, j) > dependent*square) then
        l(0, j) = sqrt(max(l(0, j), merge(rounding, dependent, bounded)*square))
        l(1:, j) = l(1:, j)/l(0, j)
      else
        l(0, j) = huge(1.0_dp)
        l(1:, j) = 0
      end if
    end do
  end subroutine factorise

  pure subroutine solve(l, x)
    !! Replace right-hand sides by the solutions for a matrix with this Cholesky factor.
    real(dp), intent(in) :: l(0:, :)
    real(dp), intent(inout) :: x(:, :)       !! (right-hand sides, columns)
    integer :: j, k, band
    band = ubound(l, 1)
    do j = 1, size(x, 2)
      x(:, j) = x(:, j)/l(0, j)
      do k = 1, min(band, size(x, 2) - j)
        x(:, j + k) = x(:, j + k) - l(k, j)*x(:, j)
      end do
    end do
    do j = size(x, 2), 1, -1
      do k = 1, min(band, size(x, 2) - j)
        x(:, j) = x(:, j) - l(k, j)*x(:, j + k)
      end do
      x(:, j) = x(:, j)/l(0, j)
    end do
  end subroutine solve

  pure subroutine project_out_missing(missing, white)
    !! Subtract from white rows the part that missing samples explain.
    type(missing_type), intent(in) :: missing
    real(dp), intent(inout) :: white(:)      !! (rows or more)
    real(dp) :: x(1, size(missing%place))
    integer :: j, low, high
    do j = 1, size(missing%place)
      call find_reach(missing, j, low, high)
      x(1, j) = dot_product(missing%filter(low:high), white(missing%place(j) - low:missing%place(j) - high:-1))
    end do
    call solve(missing%root, x)
    do j = 1, size(missing%place)
      call find_reach(missing, j, low, high)
      associate (rows => white(missing%place(j) - high:missing%place(j) - low))
        rows = rows - x(1, j)*missing%filter(high:low:-1)
      end associate
    end do
  end subroutine project_out_missing

  pure subroutine find_reach(missing, j, low, high)
    !! Find the range of the filter's coefficients by which missing sample j enters the rows.
    type(missing_type), intent(in) :: missing
    integer, intent(in) :: j
    integer, intent(out) :: low, high
    low = max(0, missing%place(j) - missing%rows)
    high = min(ubound(missing%filter, 1), missing%place(j) - 1)
  end subroutine find_reach

  pure function fills_of(missing, pole, wave_at, factors) result(x)
    !! The values at missing samples that fit a line's rows best, and those for their products with slowly varying factors; the
    !! first factor after 1 is time itself. (missing, factors)
    type(missing_type), intent(in) :: missing
    complex(dp), intent(in) :: pole
    complex(dp), intent(in) :: wave_at(:)    !! the line in the first row that each missing sample enters
    real(dp), intent(in) :: factors(:, :)    !! at the missing samples, (missing, factors)
    complex(dp) :: x(size(wave_at), size(factors, 2))
    complex(dp), dimension(0:ubound(missing%filter, 1)) :: sums, slopes   !! Σ h_i e^(z(k − i)), i = 0 … k, and its derivative by z
    complex(dp) :: step, all_of, slope
    real(dp) :: numbers(2*size(factors, 2), size(wave_at))
    integer :: i, j, low, high, n
    n = size(factors, 2)
    step = exp(pole)
    sums(0) = missing%filter(0)
    slopes(0) = 0
    do i = 1, ubound(sums, 1)
      sums(i) = sums(i - 1)*step + missing%filter(i)
      slopes(i) = (slopes(i - 1) + sums(i - 1))*step
    end do
    do j = 1, size(wave_at)
      call find_reach(missing, j, low, high)
      all_of = sums(high)
      slope = slopes(high)
      if (low > 0) then
        step = exp(pole*(high - low + 1))
        all_of = all_of - step*sums(low - 1)
        slope = slope - step*(slopes(low - 1) + (high - low + 1)*sums(low - 1))
      end if
      x(j, :) = wave_at(j)*all_of*factors(j, :)
      if (n > 1) x(j, 2) = x(j, 2) + wave_at(j)*(slope - high*all_of)
      numbers(:n, j) = x(j, :)%re
      numbers(n + 1:, j) = x(j, :)%im
    end do
    call solve(missing%root, numbers)
    x = cmplx(transpose(numbers(:n, :)), transpose(numbers(n + 1:, :)), dp)
  end function fills_of

end module bw_missing_samples
