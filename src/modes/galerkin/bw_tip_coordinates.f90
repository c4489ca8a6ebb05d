module bw_tip_coordinates
  !! Deflection v(1) and turning ψ(1) of the tip as unknowns of their own.
  !!
  !! Of the orthonormal strains z only three move the tip: ψ(1) = z_1 and v(1) = ½z_1 − (√3/6)z_2 + s z_{n+1}, the last with shear.
  !! In their place stand v(1) and ψ(1), as in a beam element, whose stiffness (4, −6, 12 without shear) they have, and with
  !! shear a third that moves neither; all others are at right angles to them. Then mass and inertia of a body at the tip stand in
  !! one place each, and the heaviest of bodies takes no digit off anything else.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: tip_coordinates_of

  type, public :: tip_coordinates
    integer :: deflection = 0                      !! the unknown v(1); it and `turning` are the last two
    integer :: turning = 0                         !! the unknown ψ(1)
    integer, allocatable, private :: mover(:)      !! strains that move the tip
    integer, allocatable, private :: other(:)      !! strains that do not
    real(dp), allocatable, private :: part(:, :)   !! of the strains that move the tip in each of the last unknowns
  contains
    procedure :: to_columns
    procedure :: to_rows
    procedure :: from_rows
  end type tip_coordinates

contains

  pure type(tip_coordinates) function tip_coordinates_of(functions, shear, turning_last) result(tip)
    integer, intent(in) :: functions               !! n, of each strain
    real(dp), intent(in), optional :: shear        !! s; absent: there are curvatures alone
    logical, intent(in) :: turning_last            !! ψ(1) is the last unknown, else v(1)
    real(dp) :: lever(2)                           ! v(1) of the second and the third strain
    integer :: j, last, unknowns
    last = merge(3, 2, present(shear))
    lever = [-sqrt(3.0_dp)/6.0_dp, 0.0_dp]
    tip%mover = [1, 2]
    unknowns = functions
    if (present(shear)) then
      lever(2) = shear
      tip%mover = [1, 2, functions + 1]
      unknowns = 2*functions
    end if
    tip%other = pack([(j, j=1, unknowns)], [(all(tip%mover /= j), j=1, unknowns)])
    tip%deflection = merge(unknowns - 1, unknowns, turning_last)
    tip%turning = merge(unknowns, unknowns - 1, turning_last)
    allocate (tip%part(last, last), source=0.0_dp)
    associate (v => tip%part(:, tip%deflection - unknowns + last), psi => tip%part(:, tip%turning - unknowns + last))
      v(2:) = lever(:last - 1)/sum(lever**2)
      psi(1) = 1.0_dp
      psi(2:) = -0.5_dp*v(2:)
    end associate
    if (present(shear)) tip%part(2:, 1) = [lever(2), -lever(1)]/norm2(lever)
  end function tip_coordinates_of

  pure subroutine to_columns(self, matrix)
    !! From columns for the strains to columns for the unknowns.
    class(tip_coordinates), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (any, unknowns)
    real(dp) :: moved(size(matrix, 1), size(self%mover))
    moved = matmul(matrix(:, self%mover), self%part)
    matrix(:, :size(self%other)) = matrix(:, self%other)
    matrix(:, size(self%other) + 1:) = moved
  end subroutine to_columns

  pure subroutine to_rows(self, matrix)
    !! The same of rows.
    class(tip_coordinates), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (unknowns, any)
    real(dp) :: moved(size(self%mover), size(matrix, 2))
    moved = matmul(transpose(self%part), matrix(self%mover, :))
    matrix(:size(self%other), :) = matrix(self%other, :)
    matrix(size(self%other) + 1:, :) = moved
  end subroutine to_rows

  pure subroutine from_rows(self, matrix)
    !! Strains from the unknowns.
    class(tip_coordinates), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (unknowns, any)
    real(dp) :: moved(size(self%mover), size(matrix, 2))
    moved = matmul(self%part, matrix(size(self%other) + 1:, :))
    matrix(self%other, :) = matrix(:size(self%other), :)
    matrix(self%mover, :) = moved
  end subroutine from_rows

end module bw_tip_coordinates
