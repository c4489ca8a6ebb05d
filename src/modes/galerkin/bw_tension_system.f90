module bw_tension_system
  !! A beam of pieces with tension, in the strains of bw_piece_strains, as a system whose modes bw_strain_modes finds: S = A + σM
  !! and B with M = BᵀB, the rows of B being the coefficients of √(mL) v and √(ρIL) ψ in each piece, and √m_b v and √J ψ of the
  !! bodies. All is exact, T being quadratic.
  !!
  !! In plane A = K − Ω²(mass of v), and σ = Ω² leaves K and Ω² times the other inertia; out of plane A = K − Ω²(inertia of ψ).
  !! A beam that its root does not clamp has 1 more, so that S is positive definite where it floats.
  use bw_double_double, only: to_dd, operator(*), operator(+)
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam
  use bw_piece_strains, only: columns_of, ends_of, layout_of, motions_of, piece_motions, strain_layout
  use bw_strain_basis, only: times_quadratic
  use bw_strain_system, only: strain_system
  implicit none (type, external)
  private
  public :: build_tension_system, tension_matrices

  type, public :: tension_beam
    !! A beam of pieces with what rotation brings into it.
    type(piece_beam) :: beam
    real(dp), allocatable :: tension(:, :)         !! T/Ω² as that of `tension_in_pieces`, (3, n)
  end type tension_beam

  type :: part_weights
    !! By how much these enter a form, beside the elastic stiffness.
    real(dp) :: tension = 0.0_dp                   !! ∫Tv'²/Ω²
    real(dp) :: deflection = 0.0_dp                !! ∫mv² and bodies' masses
    real(dp) :: turning = 0.0_dp                   !! ∫ρIψ²
    real(dp) :: inertia = 0.0_dp                   !! bodies' inertias
    real(dp) :: elastic = 1.0_dp
  end type part_weights

contains

  subroutine build_tension_system(given, functions, layout, system)
    type(tension_beam), intent(in) :: given
    integer, intent(in) :: functions(:)            !! of each strain in a piece, (n)
    type(strain_layout), intent(out) :: layout
    type(strain_system), intent(out) :: system
    type(part_weights) :: weights
    associate (square => given%beam%spin_squared%hi)
      weights%tension = square
      if (given%beam%in_plane) then
        system%shift = given%beam%spin_squared
        weights%turning = square
        weights%inertia = square
      else if (any(given%beam%piece%rotary%hi > 0.0_dp)) then
        system%shift = given%beam%spin_squared
        weights%deflection = square
        weights%inertia = square
      end if
    end associate
    if (.not. (given%beam%root%holds_deflection .and. given%beam%root%holds_turning)) then
      system%shift = system%shift + to_dd(1.0_dp)
      weights%deflection = weights%deflection + 1.0_dp
      weights%turning = weights%turning + 1.0_dp
      weights%inertia = weights%inertia + 1.0_dp
    end if
    layout = layout_of(given%beam, functions)
    call build_form(given, layout, weights, system%stiffness)
    call build_mass_root(given, layout, system%mass_root)
  end subroutine build_tension_system

  subroutine tension_matrices(given, functions, stiffness, push)
    !! The elastic stiffness, and what Ω² takes from it.
    type(tension_beam), intent(in) :: given
    integer, intent(in) :: functions(:)
    real(dp), allocatable, intent(out) :: stiffness(:, :), push(:, :)      !! (unknowns, unknowns)
    type(strain_layout) :: layout
    type(part_weights) :: weights
    layout = layout_of(given%beam, functions)
    call build_form(given, layout, part_weights(), stiffness)
    weights = part_weights(tension=-1.0_dp, elastic=0.0_dp)
    if (given%beam%in_plane) then
      weights%deflection = 1.0_dp
    else
      weights%turning = 1.0_dp
    end if
    call build_form(given, layout, weights, push)
  end subroutine tension_matrices

  pure subroutine build_form(given, layout, weights, form)
    type(tension_beam), intent(in) :: given
    type(strain_layout), intent(in) :: layout
    type(part_weights), intent(in) :: weights
    real(dp), allocatable, intent(out) :: form(:, :)   !! (unknowns, unknowns)
    integer, allocatable :: column(:)
    integer :: i
    allocate (form(layout%unknowns, layout%unknowns), source=0.0_dp)
    do i = 1, size(given%beam%piece)
      column = columns_of(layout, i)
      form(column, column) = form(column, column) + part_of_piece(given, layout, weights, i)
    end do
    associate (root => given%beam%root)
      call add_joint(layout, 0, weights%elastic*[root%stiffness%hi, root%turning_stiffness%hi], form)
    end associate
    do i = 1, size(given%beam%joint)
      associate (joint => given%beam%joint(i))
        call add_joint(layout, i, weights%elastic*[joint%stiffness%hi, joint%turning_stiffness%hi] &
                       + [weights%deflection*joint%mass%hi, weights%inertia*joint%inertia%hi], form)
      end associate
    end do
  end subroutine build_form

  pure subroutine add_joint(layout, i, values, form)
    type(strain_layout), intent(in) :: layout
    integer, intent(in) :: i
    real(dp), intent(in) :: values(2)                  !! of v² and of ψ²
    real(dp), intent(inout) :: form(:, :)
    integer :: j
    associate (n => size(layout%of_joints))
      associate (v => layout%joints%deflection(:n, i), psi => layout%joints%turning(:n, i))
        do j = 1, n
          associate (column => form(layout%of_joints, layout%of_joints(j)))
            form(layout%of_joints, layout%of_joints(j)) = column + values(1)*v(j)*v + values(2)*psi(j)*psi
          end associate
        end do
      end associate
    end associate
  end subroutine add_joint

  pure function part_of_piece(given, layout, weights, i) result(part)
    !! What a piece has of a form, by the unknowns that move it, as `columns_of` names them.
    type(tension_beam), intent(in) :: given
    type(strain_layout), intent(in) :: layout
    type(part_weights), intent(in) :: weights
    integer, intent(in) :: i
    real(dp), allocatable :: part(:, :), pulled(:, :)
    type(piece_motions) :: unit
    integer :: j
    unit = unit_motions(given, layout, i)
    associate (piece => given%beam%piece(i), length => given%beam%piece(i)%length%hi)
      part = weights%elastic*matmul(transpose(unit%strain), unit%strain)
      if (weights%tension /= 0.0_dp) then
        allocate (pulled, mold=unit%slope)
        do j = 1, size(pulled, 2)
          pulled(:, j) = times_quadratic(given%tension(:, i), unit%slope(:, j))
        end do
        part = part + weights%tension*length*matmul(transpose(unit%slope), pulled)
      end if
      if (weights%turning*piece%rotary%hi > 0.0_dp) then
        part = part + weights%turning*piece%rotary%hi*length*matmul(transpose(unit%turning), unit%turning)
      end if
      if (weights%deflection > 0.0_dp) then
        part = part + weights%deflection*piece%mass%hi*length*matmul(transpose(unit%deflection), unit%deflection)
      end if
    end associate
  end function part_of_piece

  pure type(piece_motions) function unit_motions(given, layout, i) result(motions)
    !! What each unknown of size 1 does in a piece.
    type(tension_beam), intent(in) :: given
    type(strain_layout), intent(in) :: layout
    integer, intent(in) :: i
    real(dp), allocatable :: unit(:, :), ends(:, :)
    integer :: j, joints, n
    ends = ends_of(layout, i)
    n = size(columns_of(layout, i))
    joints = count(any(ends /= 0.0_dp, dim=1))
    allocate (unit(4 + n - joints, n), source=0.0_dp)
    unit(:4, :joints) = ends(:, pack([(j, j=1, size(ends, 2))], any(ends /= 0.0_dp, dim=1)))
    do j = 1, n - joints
      unit(4 + j, joints + j) = 1.0_dp
    end do
    motions = motions_of(given%beam%piece(i), layout%functions(i), layout%shear, unit)
  end function unit_motions

  subroutine build_mass_root(given, layout, root)
    type(tension_beam), intent(in) :: given
    type(strain_layout), intent(in) :: layout
    real(dp), allocatable, intent(out) :: root(:, :)   !! (rows, unknowns)
    type(piece_motions) :: unit
    integer, allocatable :: column(:)
    integer :: i, n, row
    associate (beam => given%beam)
      n = size(beam%piece)
      allocate (root(2*sum(layout%functions + 2) + 2*n, layout%unknowns), source=0.0_dp)
      row = 0
      do i = 1, n
        column = columns_of(layout, i)
        unit = unit_motions(given, layout, i)
        associate (piece => beam%piece(i), f => layout%functions(i))
          root(row + 1:row + f + 2, column) = sqrt(piece%mass%hi*piece%length%hi)*unit%deflection
          row = row + f + 2
          if (piece%rotary%hi > 0.0_dp) then
            root(row + 1:row + f + 1, column) = sqrt(piece%rotary%hi*piece%length%hi)*unit%turning
            row = row + f + 1
          end if
        end associate
      end do
      do i = 1, n
        call add_body(beam%joint(i)%mass%hi, layout%joints%deflection(:layout%joints%number, i))
        call add_body(beam%joint(i)%inertia%hi, layout%joints%turning(:layout%joints%number, i))
      end do
      root = root(:max(row, layout%unknowns), :)
    end associate
  contains
    subroutine add_body(inertia, motion)
      real(dp), intent(in) :: inertia, motion(:)
      if (inertia == 0.0_dp) return
      row = row + 1
      root(row, layout%of_joints) = sqrt(inertia)*motion
    end subroutine add_body
  end subroutine build_mass_root

end module bw_tension_system
