module bw_singular_values
  !! The largest singular values of a matrix with their vectors, each to its own digits, by LAPACK and in steps between which
  !! the work can be left.
  !!
  !! LAPACK's dgesdd reduces a matrix to a bidiagonal one, finds the singular values of that, and transforms all vectors back.
  !! Here the reduction goes panel by panel, as in LAPACK's dgebrd, and only the vectors that are asked for are transformed back.
  !!
  !! A heavy body at the tip makes one or two columns far longer than all others, and beside the large singular value that
  !! follows the small ones would have its rounding. So the large one is deflated first. It is found by iteration from its
  !! column c: with the vector (y, 1) on the right, y ← A₁ᵀ(c + A₁y)/σ², A₁ the other columns, gains the ratio of their squares
  !! to that of c in every step and keeps every digit of y, small as it is. What is at right angles to it is a matrix of its
  !! own, with no such number in it.
  use bw_kinds, only: dp
  use bw_lapack, only: dbdsdc, dgebrd, dgemm, dlabrd, dormbr
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private
  public :: singular_values
  public :: dominant_column, deflate, undeflated     ! for their own tests

  integer, parameter :: panel = 32              !! columns that are reduced at a time, as LAPACK does
  integer, parameter :: fewest = 128            !! columns from which panels are worth it, as LAPACK has it
  integer, parameter :: batch = 64              !! vectors that are transformed back at a time
  real(dp), parameter :: longer = 2.0_dp        !! than all other columns together is one whose value is deflated
  integer, parameter :: most_steps = 40         !! of the iteration; each gains a factor of 4 and more

  type, public :: singular_triplet
    !! One singular value with its vectors on either side, of length 1.
    real(dp) :: value = 0.0_dp
    real(dp), allocatable :: left(:), right(:)
  end type singular_triplet

  type :: bidiagonal_form
    !! A matrix as Q B Pᵀ, B upper bidiagonal.
    real(dp), allocatable :: d(:), e(:)         !! of B
    real(dp), allocatable :: tauq(:), taup(:)   !! factors of the reflections in Q and P, which stand in the matrix
  end type bidiagonal_form

contains

  recursive subroutine singular_values(matrix, count, values, left, right, info, monitor)
    !! Find the largest singular values, descending, with their vectors; that of a dominant column is deflated first.
    real(dp), intent(inout) :: matrix(:, :)                           !! destroyed; not fewer rows than columns
    integer, intent(in) :: count                                      !! ≥ 1, at most as many as columns
    real(dp), allocatable, intent(out) :: values(:)
    real(dp), allocatable, intent(out) :: left(:, :), right(:, :)     !! (rows, count), (columns, count)
    integer, intent(out) :: info                                      !! 0: LAPACK had no trouble
    class(monitor_type), intent(inout), optional :: monitor           !! nothing is found where it asks to stop
    type(singular_triplet) :: largest
    real(dp), allocatable :: others(:), others_left(:, :), others_right(:, :)
    integer :: column, last
    column = dominant_column(matrix)
    if (column == 0) then
      call decompose(matrix, count, values, left, right, info, monitor)
      return
    end if
    last = size(matrix, 2)
    matrix(:, [column, last]) = matrix(:, [last, column])
    call deflate(matrix, largest)
    info = 0
    allocate (others(0), others_left(size(matrix, 1), 0), others_right(last - 1, 0))
    if (count > 1) call singular_values(matrix(:, :last - 1), count - 1, others, others_left, others_right, info, monitor)
    if (stops(monitor) .or. info /= 0) return
    values = [largest%value, others]
    left = reshape([largest%left, others_left], [size(matrix, 1), count])
    right = reshape([largest%right, undeflated(largest, others_right)], [last, count])
    right([column, last], :) = right([last, column], :)
  end subroutine singular_values

  ! Deflation

  pure integer function dominant_column(matrix) result(column)
    !! The number of a column that is longer than all others together; 0 where there is none.
    real(dp), intent(in) :: matrix(:, :)           !! (rows, columns)
    real(dp) :: length(size(matrix, 2))
    integer :: i
    length = [(norm2(matrix(:, i)), i=1, size(length))]
    column = maxloc(length, 1)
    if (length(column) <= longer*norm2([length(:column - 1), length(column + 1:)])) column = 0
  end function dominant_column

  pure subroutine deflate(matrix, largest)
    !! Find the largest singular value, and leave in all columns but the last the matrix without it.
    real(dp), intent(inout) :: matrix(:, :)        !! one whose last column dominates; that column stays as it is
    type(singular_triplet), intent(out) :: largest
    real(dp) :: y(size(matrix, 2) - 1), before(size(matrix, 2) - 1), image(size(matrix, 1)), length
    integer :: i, last
    last = size(matrix, 2)
    y = 0.0_dp
    do i = 1, most_steps
      before = y
      image = matrix(:, last) + matmul(matrix(:, :last - 1), y)
      length = norm2([y, 1.0_dp])
      largest%value = norm2(image)/length
      y = matmul(image/largest%value, matrix(:, :last - 1))/largest%value
      if (norm2(y - before) <= epsilon(1.0_dp)*norm2(y)) exit
    end do
    largest%left = image/norm2(image)
    largest%right = [y, 1.0_dp]/length
    ! the reflection that takes the right vector to the last column
    image = largest%value*largest%left + matrix(:, last)
    do i = 1, last - 1
      matrix(:, i) = matrix(:, i) - (largest%right(i)/(1.0_dp + largest%right(last)))*image
    end do
  end subroutine deflate

  pure function undeflated(largest, right) result(whole)
    !! Right vectors of the deflated matrix as vectors of the whole one.
    type(singular_triplet), intent(in) :: largest  !! what was deflated
    real(dp), intent(in) :: right(:, :)            !! (columns but one, vectors)
    real(dp) :: whole(size(right, 1) + 1, size(right, 2))
    real(dp) :: along(size(right, 2))
    integer :: i, last
    last = size(largest%right)
    along = matmul(largest%right(:last - 1), right)
    do i = 1, last - 1
      whole(i, :) = right(i, :) - (largest%right(i)/(1.0_dp + largest%right(last)))*along
    end do
    whole(last, :) = -along
  end function undeflated

  ! LAPACK's way

  subroutine decompose(matrix, count, values, left, right, info, monitor)
    !! Find singular values as above of a matrix without a dominant column.
    real(dp), contiguous, intent(inout) :: matrix(:, :)               !! arguments as those of `singular_values`
    integer, intent(in) :: count
    real(dp), allocatable, intent(out) :: values(:), left(:, :), right(:, :)
    integer, intent(out) :: info
    class(monitor_type), intent(inout), optional :: monitor
    type(bidiagonal_form) :: reduced
    real(dp), allocatable :: u(:, :), vt(:, :), work(:)
    integer, allocatable :: iwork(:)
    real(dp) :: unused(1)
    integer :: unused_too(1), m, n
    m = size(matrix, 1)
    n = size(matrix, 2)
    call reduce(m, n, matrix, reduced, info, monitor)
    if (stops(monitor)) return
    if (info /= 0) return
    allocate (u(n, n), vt(n, n), work(3*n**2 + 4*n), iwork(8*n))
    call dbdsdc('U', 'I', n, reduced%d, reduced%e, u, n, vt, n, unused, unused_too, work, iwork, info)
    if (info /= 0) return
    values = reduced%d(:count)
    allocate (left(m, count), right(n, count))
    left(:n, :) = u(:, :count)
    left(n + 1:, :) = 0.0_dp
    right = transpose(vt(:count, :))
    call transform_back('Q', matrix, reduced%tauq, left, info, monitor)
    call transform_back('P', matrix, reduced%taup, right, info, monitor)
  end subroutine decompose

  subroutine reduce(m, n, a, reduced, info, monitor)
    !! Reduce a matrix to bidiagonal form. After every panel two products change what is not reduced yet.
    integer, intent(in) :: m, n
    real(dp), intent(inout) :: a(m, n)
    type(bidiagonal_form), intent(out) :: reduced
    integer, intent(out) :: info
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), allocatable :: x(:, :), y(:, :), work(:)
    integer :: i, j, rows, columns
    allocate (reduced%d(n), reduced%e(n), reduced%tauq(n), reduced%taup(n), x(m, panel), y(n, panel), work(panel*(m + n)))
    info = 0
    i = 1
    associate (d => reduced%d, e => reduced%e, tauq => reduced%tauq, taup => reduced%taup)
      do while (n - i + 1 > fewest)
        call dlabrd(m - i + 1, n - i + 1, panel, a(i, i), m, d(i), e(i), tauq(i), taup(i), x, m, y, n)
        j = i + panel
        rows = m - j + 1
        columns = n - j + 1
        call dgemm('N', 'T', rows, columns, panel, -1.0_dp, a(j, i), m, y(panel + 1, 1), n, 1.0_dp, a(j, j), m)
        call dgemm('N', 'N', rows, columns, panel, -1.0_dp, x(panel + 1, 1), m, a(i, j), m, 1.0_dp, a(j, j), m)
        i = j
        if (stops(monitor)) return
      end do
      call dgebrd(m - i + 1, n - i + 1, a(i, i), m, d(i), e(i), tauq(i), taup(i), work, size(work), info)
    end associate
  end subroutine reduce

  subroutine transform_back(side, a, tau, vectors, info, monitor)
    !! Turn singular vectors of the bidiagonal form into those of the matrix.
    character, intent(in) :: side               !! 'Q': on the left, 'P': on the right
    real(dp), intent(inout) :: a(:, :)          !! with the reflections
    real(dp), intent(in) :: tau(:)
    real(dp), intent(inout) :: vectors(:, :)
    integer, intent(inout) :: info
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), allocatable :: work(:)
    integer :: first
    allocate (work(panel*batch + 65*64))        ! what dormbr asks for: blocks, and their triangular factors
    do first = 1, size(vectors, 2), batch
      if (stops(monitor)) return
      associate (slice => vectors(:, first:min(first + batch - 1, size(vectors, 2))))
        if (info == 0) call dormbr(side, 'L', 'N', size(slice, 1), size(slice, 2), size(a, 2), a, size(a, 1), tau, &
                                   slice, size(slice, 1), work, size(work), info)
      end associate
    end do
  end subroutine transform_back

end module bw_singular_values
