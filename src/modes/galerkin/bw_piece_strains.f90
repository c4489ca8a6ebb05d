module bw_piece_strains
  !! The unknowns for the strains of a beam of pieces: motions of the joints (bw_joint_unknowns), and in each piece
  !! strains that do not move its ends.
  !!
  !! With x from 0 to 1 along a piece of length L the curvature is Σa_jp_j/√(BL) and the shear strain √(s/L)Σb_jp_j, so
  !! the elastic energy of a uniform piece is ½Σa² + ½Σb²; strains may be discontinuous. ψ and v are integrals from the
  !! inner joint. Only a_0, a_1 and b_0 move the outer joint: e = Δψ = √(L/B)a_0, and d = Δv/L − ½(ψ + ψ') =
  !! −√(L/B)(√3/6)a_1 + √(s/L)b_0. The joints' motions replace them, as in a beam element, with the smallest energy of a
  !! uniform piece; with shear a third strain moves nothing. All others are orthogonal to these.
  use bw_joint_unknowns, only: joint_unknowns, unknowns_of_joints
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam, uniform_piece
  use bw_strain_basis, only: integral, integral_transposed
  implicit none (type, external)
  private
  public :: layout_of, motions_of, forces_on, ends_of, columns_of, strains_inside

  type, public :: strain_layout
    !! The layout of unknowns: strains inside pieces first, then those of the joints.
    integer, allocatable :: functions(:)           !! of each strain in a piece, ≥ 3, (n)
    logical :: shear = .false.
    integer, allocatable :: inside(:)              !! number of unknowns before those of a piece, (n)
    type(joint_unknowns) :: joints
    integer, allocatable :: of_joints(:)           !! indices of their unknowns
    integer :: unknowns = 0
  end type strain_layout

  type, public :: piece_motions
    !! Motions of a piece for several columns of unknowns.
    real(dp), allocatable :: strain(:, :)          !! a, and with shear b, (strains, columns)
    real(dp), allocatable :: turning(:, :)         !! coefficients of ψ, (functions + 1, columns)
    real(dp), allocatable :: slope(:, :)           !! of v', (functions + 1, columns)
    real(dp), allocatable :: deflection(:, :)      !! of v, (functions + 2, columns)
  end type piece_motions

  type, public :: piece_forces
    !! Generalised forces on the motions of one column.
    real(dp), allocatable :: strain(:), turning(:), slope(:), deflection(:)
  end type piece_forces

  type :: strain_scales
    !! Motion of a piece per strain of size 1.
    real(dp) :: length = 1.0_dp                    !! L
    real(dp) :: turn = 1.0_dp                      !! √(L/B)
    real(dp) :: shear = 0.0_dp                     !! √(s/L)
    real(dp) :: share(2) = 0.0_dp                  !! of a_1 and b_0 in d
    real(dp) :: across(2) = 0.0_dp                 !! of both in a motion that leaves the ends in place
  end type strain_scales

contains

  type(strain_layout) function layout_of(beam, functions) result(layout)
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: functions(:)            !! of each strain in a piece, ≥ 3, (n)
    integer :: i, j, n
    n = size(functions)
    layout%functions = functions
    layout%shear = any(beam%piece%compliance%hi > 0.0_dp)
    layout%inside = [(sum([(strains_inside(functions(j), layout%shear), j=1, i - 1)]), i=1, n)]
    layout%joints = unknowns_of_joints(beam)
    associate (before => layout%inside(n) + strains_inside(functions(n), layout%shear))
      layout%of_joints = [(before + i, i=1, layout%joints%number)]
      layout%unknowns = before + layout%joints%number
    end associate
  end function layout_of

  elemental integer function strains_inside(functions, shear) result(number)
    !! Count the strains that do not move the ends of a piece.
    integer, intent(in) :: functions
    logical, intent(in) :: shear
    number = merge(2*functions - 2, functions - 2, shear)
  end function strains_inside

  pure function columns_of(layout, i) result(column)
    !! Return the unknowns that move piece i: those of the joints at its ends, and those inside.
    type(strain_layout), intent(in) :: layout
    integer, intent(in) :: i
    integer, allocatable :: column(:)
    integer :: j
    column = [pack(layout%of_joints, any(ends_of(layout, i) /= 0.0_dp, dim=1)), &
              (layout%inside(i) + j, j=1, strains_inside(layout%functions(i), layout%shear))]
  end function columns_of

  pure function ends_of(layout, i) result(ends)
    !! Return v and ψ of the inner end of piece i, e and d, for each unknown of the joints, (4, unknowns of joints).
    type(strain_layout), intent(in) :: layout
    integer, intent(in) :: i
    real(dp) :: ends(4, size(layout%of_joints))
    associate (joints => layout%joints, n => size(layout%of_joints))
      ends(1, :) = joints%deflection(:n, i - 1)
      ends(2, :) = joints%turning(:n, i - 1)
      ends(3, :) = joints%bend(:n, i)
      ends(4, :) = joints%shift(:n, i)
    end associate
  end function ends_of

  pure type(piece_motions) function motions_of(piece, functions, shear, columns) result(motions)
    !! Return the motions for given v and ψ of the inner end, e and d, and strains inside.
    type(uniform_piece), intent(in) :: piece
    integer, intent(in) :: functions
    logical, intent(in) :: shear
    real(dp), intent(in) :: columns(:, :)          !! (4 + strains inside, motions)
    type(strain_scales) :: scale
    integer :: j, n
    n = functions
    scale = scales_of(piece)
    allocate (motions%strain(merge(2*n, n, shear), size(columns, 2)))
    allocate (motions%turning(n + 1, size(columns, 2)), motions%slope(n + 1, size(columns, 2)))
    allocate (motions%deflection(n + 2, size(columns, 2)))
    do j = 1, size(columns, 2)
      associate (c => columns(:, j), strain => motions%strain(:, j), psi => motions%turning(:, j), slope => motions%slope(:, j))
        strain(1) = c(3)/scale%turn
        strain(2) = c(4)*scale%share(1)
        strain(3:n) = c(5:n + 2)
        if (shear) then
          strain(n + 1) = c(4)*scale%share(2)
          strain(n + 2:) = c(n + 4:)
          strain([2, n + 1]) = strain([2, n + 1]) + c(n + 3)*scale%across
        end if
        psi = scale%turn*integral(strain(:n))
        psi(1) = psi(1) + c(2)
        slope = psi
        if (shear) slope(:n) = slope(:n) + scale%shear*strain(n + 1:)
        motions%deflection(:, j) = scale%length*integral(slope)
        motions%deflection(1, j) = motions%deflection(1, j) + c(1)
      end associate
    end do
  end function motions_of

  pure function forces_on(piece, functions, shear, given) result(force)
    !! Apply the transpose of `motions_of` for one column: forces on strains, rotation, slope and deflection as forces
    !! on the unknowns, (4 + strains inside).
    type(uniform_piece), intent(in) :: piece
    integer, intent(in) :: functions
    logical, intent(in) :: shear
    type(piece_forces), intent(in) :: given
    real(dp), allocatable :: force(:)
    real(dp), dimension(functions + 1) :: slope, psi
    real(dp) :: strain(size(given%strain))
    type(strain_scales) :: scale
    integer :: n
    n = functions
    scale = scales_of(piece)
    allocate (force(4 + strains_inside(n, shear)))
    force(1) = given%deflection(1)
    slope = given%slope + scale%length*integral_transposed(given%deflection)
    strain = given%strain
    if (shear) strain(n + 1:) = strain(n + 1:) + scale%shear*slope(:n)
    psi = given%turning + slope
    force(2) = psi(1)
    strain(:n) = strain(:n) + scale%turn*integral_transposed(psi)
    force(3) = strain(1)/scale%turn
    force(4) = scale%share(1)*strain(2)
    force(5:n + 2) = strain(3:n)
    if (.not. shear) return
    force(4) = force(4) + scale%share(2)*strain(n + 1)
    force(n + 3) = dot_product(scale%across, strain([2, n + 1]))
    force(n + 4:) = strain(n + 2:)
  end function forces_on

  pure type(strain_scales) function scales_of(piece) result(scale)
    type(uniform_piece), intent(in) :: piece
    real(dp) :: lever(2)
    scale%length = piece%length%hi
    scale%turn = sqrt(piece%length%hi/piece%stiffness%hi)
    scale%shear = sqrt(piece%compliance%hi/piece%length%hi)
    lever = [-scale%turn*sqrt(3.0_dp)/6.0_dp, scale%shear]
    scale%share = lever/sum(lever**2)
    scale%across = [lever(2), -lever(1)]/norm2(lever)
  end function scales_of

end module bw_piece_strains
