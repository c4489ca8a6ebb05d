module bw_piece_strains
  !! What the strains of a beam of pieces are written in: deflection and turning of the joints, and in each piece strains that
  !! move neither of its ends.
  !!
  !! With x from 0 to 1 over a piece of length L the curvature is Σa_jp_j/√(BL) and the shear strain √(s/L)Σb_jp_j, so that the
  !! elastic energy is ½Σa² + ½Σb²; strains need not be continuous. ψ and v are integrals from the inner joint. Of all strains
  !! only a_0, a_1 and b_0 move the outer joint: Δψ = √(L/B)a_0, and Δv/L − ½(ψ + ψ') = −√(L/B)(√3/6)a_1 + √(s/L)b_0. The joints'
  !! motions stand for them, as in a beam element, with the smallest energy; with shear a third strain moves nothing. All others
  !! are at right angles to these. Bodies and springs then touch one unknown each.
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam, uniform_piece
  use bw_strain_basis, only: integral
  implicit none (type, external)
  private
  public :: layout_of, motions_of, columns_of

  type, public :: strain_layout
    !! Where the unknowns stand: strains inside of the pieces first, then the joints, the heaviest last.
    integer, allocatable :: functions(:)           !! of each strain in a piece, ≥ 3, (n)
    logical :: shear = .false.
    integer, allocatable :: inside(:)              !! unknowns before those inside of a piece, (n)
    integer, allocatable :: joint(:, :)            !! v and ψ of each joint; 0: held, (2, 0:n)
    integer :: unknowns = 0
  end type strain_layout

  type, public :: piece_motions
    !! What columns of unknowns do in a piece.
    real(dp), allocatable :: strain(:, :)          !! a, and with shear b, (strains, columns)
    real(dp), allocatable :: turning(:, :)         !! coefficients of ψ, (functions + 1, columns)
    real(dp), allocatable :: slope(:, :)           !! of v', (functions + 1, columns)
    real(dp), allocatable :: deflection(:, :)      !! of v, (functions + 2, columns)
  end type piece_motions

contains

  type(strain_layout) function layout_of(beam, functions) result(layout)
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: functions(:)            !! of each strain in a piece, ≥ 3, (n)
    real(dp) :: weight(0:size(functions))
    integer :: i, j, n
    n = size(functions)
    layout%functions = functions
    layout%shear = any(beam%piece%compliance%hi > 0.0_dp)
    layout%inside = [(sum([(strains_inside(functions(j), layout%shear), j=1, i - 1)]), i=1, n)]
    layout%unknowns = layout%inside(n) + strains_inside(functions(n), layout%shear)
    allocate (layout%joint(2, 0:n), source=0)
    weight(0) = 0.0_dp
    weight(1:) = max(beam%joint%mass%hi, beam%joint%inertia%hi)
    do j = 0, n
      i = minloc(weight, 1) - 1
      weight(i) = huge(weight)
      call place(i, merge(2, 1, heavy_turning(i)))
      call place(i, merge(1, 2, heavy_turning(i)))
    end do
  contains
    pure logical function heavy_turning(i)
      !! The body's mass moves less than its inertia.
      integer, intent(in) :: i
      heavy_turning = .false.
      if (i > 0) heavy_turning = beam%joint(i)%mass%hi > 3.0_dp*beam%joint(i)%inertia%hi
    end function heavy_turning
    subroutine place(i, which)
      integer, intent(in) :: i, which
      if (i == 0 .and. merge(beam%root%holds_deflection, beam%root%holds_turning, which == 1)) return
      layout%unknowns = layout%unknowns + 1
      layout%joint(which, i) = layout%unknowns
    end subroutine place
  end function layout_of

  elemental integer function strains_inside(functions, shear) result(number)
    !! How many strains move neither end of a piece.
    integer, intent(in) :: functions
    logical, intent(in) :: shear
    number = merge(2*functions - 2, functions - 2, shear)
  end function strains_inside

  pure function columns_of(layout, i) result(column)
    !! The unknowns that move piece i: v and ψ of its inner and its outer end, 0 where held, and what is inside.
    type(strain_layout), intent(in) :: layout
    integer, intent(in) :: i
    integer :: column(4 + strains_inside(layout%functions(i), layout%shear))
    integer :: j
    column(1:2) = layout%joint(:, i - 1)
    column(3:4) = layout%joint(:, i)
    column(5:) = [(layout%inside(i) + j, j=1, size(column) - 4)]
  end function columns_of

  pure type(piece_motions) function motions_of(piece, functions, shear, columns) result(motions)
    !! Of values of the unknowns that `columns_of` names, in their order.
    type(uniform_piece), intent(in) :: piece
    integer, intent(in) :: functions
    logical, intent(in) :: shear
    real(dp), intent(in) :: columns(:, :)          !! (columns_of, motions)
    real(dp) :: turn, shift, lever(2), length
    integer :: j, n
    n = functions
    length = piece%length%hi
    turn = sqrt(length/piece%stiffness%hi)
    lever = [-turn*sqrt(3.0_dp)/6.0_dp, sqrt(piece%compliance%hi/length)]
    allocate (motions%strain(merge(2*n, n, shear), size(columns, 2)))
    allocate (motions%turning(n + 1, size(columns, 2)), motions%slope(n + 1, size(columns, 2)))
    allocate (motions%deflection(n + 2, size(columns, 2)))
    do j = 1, size(columns, 2)
      associate (c => columns(:, j), strain => motions%strain(:, j), psi => motions%turning(:, j), slope => motions%slope(:, j))
        shift = (c(3) - c(1))/length - 0.5_dp*(c(2) + c(4))
        strain(1) = (c(4) - c(2))/turn
        strain(2) = shift*lever(1)/sum(lever**2)
        strain(3:n) = c(5:n + 2)
        if (shear) then
          strain(n + 1) = shift*lever(2)/sum(lever**2)
          strain(n + 2:) = c(n + 4:)
          strain([2, n + 1]) = strain([2, n + 1]) + c(n + 3)*[lever(2), -lever(1)]/norm2(lever)
        end if
        psi = turn*integral(strain(:n))
        psi(1) = psi(1) + c(2)
        slope = psi
        if (shear) slope(:n) = slope(:n) + lever(2)*strain(n + 1:)
        motions%deflection(:, j) = length*integral(slope)
        motions%deflection(1, j) = motions%deflection(1, j) + c(1)
      end associate
    end do
  end function motions_of

end module bw_piece_strains
