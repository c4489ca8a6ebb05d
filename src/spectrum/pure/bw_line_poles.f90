module bw_line_poles
  !! Positions of overlapping lines: the transform of a sum of exponentials is a rational function of the bin, and its
  !! poles are the lines. They are found from a Loewner pencil of all sensors' bins.
  !! Source: Derevianko, Plonka, Petz, IMA J. Numer. Anal. 43 (2023) 789 (ESPIRA); Mayo, Antoulas (2007).
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_lapack, only: zgeev, zgesvd
  use bw_line, only: highest, line_type
  use bw_tapered_line, only: line_image, line_in_record
  use bw_tapered_residual, only: plain_bins, residual_type
  implicit none (type, external)
  private
  public :: ample_pencil, pole_lines

  integer, parameter :: least_beside = 5       !! bins beside a group from which its poles are found
  integer, parameter :: most_beside = 40
  real(dp), parameter :: at_edge = 1.0e-3_dp   !! bins; a pole no farther below 0 is not a mirror image
  real(dp), parameter :: grows = 1.0e-3_dp     !! over the record; slower motion at 0 may also be a drift
  integer, parameter :: spare = 4  !! columns after each matrix: zgemv of OpenBLAS 0.3.21 reads past the last one
                                   !! (github.com/OpenMathLib/OpenBLAS/issues/5000)
  real(dp), parameter :: rounding = 1.0e-13_dp  !! relative to the largest singular value

  type, public :: pencil_type
    integer :: middle = 0                       !! bin
    integer :: count = 0                        !! samples in the record
    real(dp), allocatable :: singular(:)        !! of the divided differences, descending
    complex(dp), allocatable :: shifted(:, :)   !! the shifted differences in the basis of the singular vectors
  end type pencil_type

contains

  subroutine ample_pencil(residual, own, bins, noise, pencil, rank)
    !! Make a pencil over enough bins that its rank, which counts the lines, is well below its size.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: own(:)
    integer, intent(in) :: bins(2)
    real(dp), intent(in) :: noise
    type(pencil_type), intent(out) :: pencil
    integer, intent(out) :: rank
    integer :: beside
    beside = least_beside
    do
      pencil = group_pencil(residual, own, bins, beside)
      rank = rank_of(pencil, noise)
      if (4*rank < 3*size(pencil%singular) .or. beside > most_beside .or. 2*beside > residual%count) exit
      beside = 2*beside
    end do
  end subroutine ample_pencil

  function group_pencil(residual, own, bins, beside) result(pencil)
    !! The pencil of the group's bins and of `beside` more at either end; for a group near 0, of bins on both sides of 0.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: own(:)      !! lines of the group so far, which `residual` does not contain
    integer, intent(in) :: bins(2), beside
    type(pencil_type) :: pencil
    complex(dp), allocatable :: image(:, :)
    integer :: first, last, i
    first = bins(1) - beside
    last = bins(2) + beside
    if (bins(1) == 0) first = -last
    if (bins(2) == residual%count/2) last = residual%count - first
    if (last - first >= residual%count) then
      first = -((residual%count - 1)/2)
      last = residual%count/2
    end if
    allocate (image(first:last, size(residual%plain, 2)), source=plain_bins(residual, first, last))
    do i = 1, size(own)
      image = image + line_image(own(i), residual%count, [first, last], .false.)
    end do
    pencil = pencil_of(image, first, residual%count)
  end function group_pencil

  function pole_lines(pencil, rank, bins) result(lines)
    !! The lines at the poles among the group's bins, without mirror images at negative frequency. A pole at 0 that grows is a
    !! real exponential: put at 0 exactly, it stays there, since it has no phase and no derivative by its offset.
    type(pencil_type), intent(in) :: pencil
    integer, intent(in) :: rank, bins(2)
    type(line_type), allocatable :: lines(:)
    real(dp), allocatable :: position(:), growth(:)
    integer :: i
    allocate (lines(0))
    call find_poles(pencil, rank, position, growth)
    where (abs(position) < at_edge .and. abs(growth) > grows) position = 0
    do i = 1, size(position)
      if (position(i) < max(bins(1) - 1.0_dp, -at_edge) .or. position(i) > bins(2) + 1) cycle
      if (2*position(i) > pencil%count + at_edge .or. abs(growth(i)) > highest) cycle
      lines = [lines, line_in_record(position(i), growth(i), pencil%count)]
    end do
  end function pole_lines

  function pencil_of(image, first, count) result(pencil)
    !! The Loewner pencil of an image, in the basis of its singular vectors.
    integer, intent(in) :: first                  !! first bin, may be negative
    complex(dp), intent(in) :: image(first:, :)   !! transform without taper, (bins, S)
    integer, intent(in) :: count                  !! samples in the record
    type(pencil_type) :: pencil
    complex(dp), allocatable :: difference(:, :), shifted(:, :), left(:, :), right(:, :)
    integer :: n
    pencil%count = count
    pencil%middle = first + size(image, 1)/2
    call loewner(image, first, count, pencil%middle, difference, shifted)
    n = size(difference, 2)
    call singular_vectors(difference, pencil%singular, left, right)
    shifted = matmul(shifted, conjg(transpose(right(:, :n))))
    allocate (pencil%shifted, source=matmul(conjg(transpose(left(:, :n))), shifted))
  end function pencil_of

  pure integer function rank_of(pencil, noise)
    !! The number of poles that exceed noise of this size in the bins, and rounding.
    type(pencil_type), intent(in) :: pencil
    real(dp), intent(in) :: noise
    rank_of = count(pencil%singular > max(noise*size(pencil%singular), rounding*pencil%singular(1)))
  end function rank_of

  subroutine find_poles(pencil, rank, position, growth)
    !! Find the poles of the rational function of degree `rank`.
    type(pencil_type), intent(in) :: pencil
    integer, intent(in) :: rank                   !! ≥ 1
    real(dp), allocatable, intent(out) :: position(:)  !! bins; none if the degree is too high
    real(dp), allocatable, intent(out) :: growth(:)    !! logarithm of growth over the record
    complex(dp) :: reduced(rank, rank), pole(rank)
    logical :: found
    integer :: i
    allocate (position(0), growth(0))
    if (rank > size(pencil%singular)) return
    if (pencil%singular(rank) <= tiny(1.0_dp)) return
    do i = 1, rank
      reduced(i, :) = pencil%shifted(i, :rank)/pencil%singular(i)
    end do
    call find_eigenvalues(reduced, pole, found)
    if (.not. found) return
    pole = pencil%count*logarithm(pole*cmplx(0, 2*pi, dp)/pencil%count)
    position = pencil%middle + pole%im/(2*pi)
    growth = pole%re
  end subroutine find_poles

  pure subroutine loewner(image, first, count, middle, pencil, shifted)
    !! Compute the divided differences of F = Y/ω and of ωF between even and odd bins, with all sensors below each other, in the
    !! variable (ω − ω_middle)/(2πi ω_middle/N), which is close to the bin's distance from the middle.
    integer, intent(in) :: first, count, middle
    complex(dp), intent(in) :: image(first:, :)
    complex(dp), allocatable, intent(out) :: pencil(:, :), shifted(:, :)
    complex(dp) :: node(first:ubound(image, 1)), f(first:ubound(image, 1))
    integer :: rows, columns, i, j, m, n, p
    columns = size(image, 1)/2
    rows = size(image, 1) - columns
    allocate (pencil(size(image, 2)*rows, columns), shifted(size(image, 2)*rows, columns))
    node = [(local_node(m - middle, count), m=first, ubound(image, 1))]
    do p = 1, size(image, 2)
      f = image(:, p)*[(exp(cmplx(0, -2*pi*(m - middle)/count, dp)), m=first, ubound(image, 1))]
      do j = 1, columns
        n = first + 2*j - 1
        do i = 1, rows
          m = first + 2*i - 2
          pencil(rows*(p - 1) + i, j) = (f(m) - f(n))/(node(m) - node(n))
          shifted(rows*(p - 1) + i, j) = (node(m)*f(m) - node(n)*f(n))/(node(m) - node(n))
        end do
      end do
    end do
  end subroutine loewner

  pure complex(dp) function local_node(away, count)
    !! The variable of the rational function, `away` bins from the middle: (e^(ix) − 1) N/(2πi), x = 2π away/N.
    integer, intent(in) :: away, count
    real(dp) :: x
    x = pi*away/count
    local_node = sin(x)*exp(cmplx(0, x, dp))*count/pi
  end function local_node

  elemental complex(dp) function logarithm(z)
    !! The logarithm of 1 + z, without cancellation for small |z|; for 1 + z = 0 it is a large negative growth.
    complex(dp), intent(in) :: z
    complex(dp) :: rounded
    rounded = 1 + z
    if (abs(rounded) < tiny(1.0_dp)) then
      logarithm = -700
    else if (abs(z) < 1.0e-4_dp) then
      logarithm = z*(1 - z*(0.5_dp - z*(1/3.0_dp - z/4)))
    else
      logarithm = log(rounded)
    end if
  end function logarithm

  subroutine singular_vectors(matrix, singular, left, right)
    !! Find the singular values, descending, and the singular vectors of a matrix of at least as many rows as columns.
    complex(dp), intent(in) :: matrix(:, :)
    real(dp), allocatable, intent(out) :: singular(:)
    complex(dp), allocatable, intent(out) :: left(:, :), right(:, :)  !! columns, conjugated rows; then `spare` more
    complex(dp) :: a(size(matrix, 1), size(matrix, 2) + spare), work(32*sum(shape(matrix)))
    real(dp) :: scratch(5*size(matrix, 2))
    integer :: m, n, info
    m = size(matrix, 1)
    n = size(matrix, 2)                           ! n ≤ m
    allocate (singular(n), left(m, n + spare), right(n, n + spare))
    a = 0
    a(:, :n) = matrix
    singular = 0
    left = 0
    right = 0
    work = 0
    scratch = 0
    call zgesvd('S', 'S', m, n, a, m, singular, left, m, right, n, work, size(work), scratch, info)
    if (info /= 0) singular = 0                   ! no pole is found
  end subroutine singular_vectors

  subroutine find_eigenvalues(matrix, values, found)
    !! Find the eigenvalues of a square matrix.
    complex(dp), intent(in) :: matrix(:, :)
    complex(dp), intent(out) :: values(size(matrix, 1))
    logical, intent(out) :: found                 !! all were found
    complex(dp) :: a(size(matrix, 1), size(matrix, 1) + spare), none(1, 1), work(32*size(matrix, 1))
    real(dp) :: scratch(2*size(matrix, 1))
    integer :: n, info
    n = size(matrix, 1)
    a = 0
    a(:, :n) = matrix
    values = 0
    none = 0
    work = 0
    scratch = 0
    call zgeev('N', 'N', n, a, n, values, none, 1, none, 1, work, size(work), scratch, info)
    found = info == 0
  end subroutine find_eigenvalues

end module bw_line_poles
