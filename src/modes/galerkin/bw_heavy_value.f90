module bw_heavy_value
  !! Singular values of a matrix, one or two columns of which are far longer than all others, as those of a heavy body are.
  !!
  !! Side by side the small values would have the large one's rounding. So the large one is found first, by iteration from its
  !! column c: with the vector (y, 1) on the right, y ← A₁ᵀ(c + A₁y)/σ², A₁ the other columns, gains the ratio of their squares to
  !! that of c in every step and keeps every digit of y, small as it is. What is at right angles to it then is a matrix of
  !! its own, with no such number in it.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: heavy_column, take_heavy, give_heavy

  real(dp), parameter :: longer = 2.0_dp
  integer, parameter :: most_steps = 40            !! each gains a factor of 4 and more

  type, public :: heavy_value
    real(dp) :: value = 0.0_dp
    real(dp), allocatable :: left(:), right(:)     !! its vectors, of length 1
  end type heavy_value

contains

  pure integer function heavy_column(matrix) result(column)
    !! A column that is longer than all others together; 0 where there is none.
    real(dp), intent(in) :: matrix(:, :)           !! (rows, columns)
    real(dp) :: length(size(matrix, 2))
    integer :: i
    length = [(norm2(matrix(:, i)), i=1, size(length))]
    column = maxloc(length, 1)
    if (length(column) <= longer*norm2([length(:column - 1), length(column + 1:)])) column = 0
  end function heavy_column

  pure subroutine take_heavy(matrix, heavy)
    !! The largest value, and in all columns but the last the matrix without it.
    real(dp), intent(inout) :: matrix(:, :)        !! one whose last column is heavy; it is left as it is
    type(heavy_value), intent(out) :: heavy
    real(dp) :: y(size(matrix, 2) - 1), before(size(matrix, 2) - 1), image(size(matrix, 1)), length
    integer :: i, last
    last = size(matrix, 2)
    y = 0.0_dp
    do i = 1, most_steps
      before = y
      image = matrix(:, last) + matmul(matrix(:, :last - 1), y)
      length = norm2([y, 1.0_dp])
      heavy%value = norm2(image)/length
      y = matmul(image/heavy%value, matrix(:, :last - 1))/heavy%value
      if (norm2(y - before) <= epsilon(1.0_dp)*norm2(y)) exit
    end do
    heavy%left = image/norm2(image)
    heavy%right = [y, 1.0_dp]/length
    ! the reflection that takes the right vector to the last column
    image = heavy%value*heavy%left + matrix(:, last)
    do i = 1, last - 1
      matrix(:, i) = matrix(:, i) - (heavy%right(i)/(1.0_dp + heavy%right(last)))*image
    end do
  end subroutine take_heavy

  pure function give_heavy(heavy, right) result(whole)
    !! Right vectors of what was left, as vectors of the whole matrix.
    type(heavy_value), intent(in) :: heavy
    real(dp), intent(in) :: right(:, :)            !! (columns but one, vectors)
    real(dp) :: whole(size(right, 1) + 1, size(right, 2))
    real(dp) :: along(size(right, 2))
    integer :: i, last
    last = size(heavy%right)
    along = matmul(heavy%right(:last - 1), right)
    do i = 1, last - 1
      whole(i, :) = right(i, :) - (heavy%right(i)/(1.0_dp + heavy%right(last)))*along
    end do
    whole(last, :) = -along
  end function give_heavy

end module bw_heavy_value
