module bw_tip_coordinate
  !! The one unknown that moves the tip.
  !!
  !! In orthonormal strains z the tip's deflection is v(1) = τᵀz, τ = (½, −√3/6) for the first two curvatures and s for the
  !! first shear strain. A reflection of these three unknowns leaves one alone that moves the tip, and that one is put last:
  !! then a mass at the tip stands in one place of each matrix, and the largest of masses takes no digit off the others.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: tip_coordinate_of

  type, public :: tip_coordinate
    private
    integer, allocatable :: mover(:)               !! unknowns that move the tip; the first of them is put last
    real(dp), allocatable :: normal(:)             !! of the reflection, of length 1
    real(dp), public :: lever = 0.0_dp             !! v(1) for 1 of the last unknown
  contains
    procedure :: turn_columns
    procedure :: turn_rows
    procedure :: turn_back
  end type tip_coordinate

contains

  pure type(tip_coordinate) function tip_coordinate_of(functions, shear) result(tip)
    integer, intent(in) :: functions               !! n, of each strain
    real(dp), intent(in), optional :: shear        !! s; absent: there are curvatures alone
    tip%mover = [1, 2]
    tip%normal = [0.5_dp, -sqrt(3.0_dp)/6.0_dp]
    if (present(shear)) then
      tip%mover = [tip%mover, functions + 1]
      tip%normal = [tip%normal, shear]
    end if
    tip%lever = -norm2(tip%normal)
    tip%normal(1) = tip%normal(1) - tip%lever
    tip%normal = tip%normal/norm2(tip%normal)
  end function tip_coordinate_of

  pure subroutine turn_rows(self, matrix)
    !! From rows for the unknowns to rows for these with the tip's own last.
    class(tip_coordinate), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (unknowns, any)
    call reflect(self, matrix)
    call swap_ends(matrix)
  end subroutine turn_rows

  pure subroutine turn_columns(self, matrix)
    !! The same of columns.
    class(tip_coordinate), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (any, unknowns)
    real(dp) :: rows(size(matrix, 2), size(matrix, 1))
    rows = transpose(matrix)
    call self%turn_rows(rows)
    matrix = transpose(rows)
  end subroutine turn_columns

  pure subroutine turn_back(self, matrix)
    !! From rows with the tip's own last to rows for the unknowns.
    class(tip_coordinate), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (unknowns, any)
    call swap_ends(matrix)
    call reflect(self, matrix)
  end subroutine turn_back

  pure subroutine reflect(tip, matrix)
    type(tip_coordinate), intent(in) :: tip
    real(dp), intent(inout) :: matrix(:, :)
    real(dp) :: along(size(matrix, 2))
    integer :: i
    along = 2.0_dp*matmul(tip%normal, matrix(tip%mover, :))
    do i = 1, size(tip%mover)
      matrix(tip%mover(i), :) = matrix(tip%mover(i), :) - tip%normal(i)*along
    end do
  end subroutine reflect

  pure subroutine swap_ends(matrix)
    real(dp), intent(inout) :: matrix(:, :)
    real(dp) :: row(size(matrix, 2))
    row = matrix(1, :)
    matrix(1, :) = matrix(size(matrix, 1), :)
    matrix(size(matrix, 1), :) = row
  end subroutine swap_ends

end module bw_tip_coordinate
