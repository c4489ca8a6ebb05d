module bw_strain_system
  !! The matrices of a beam of pieces with tension, uniform or tapering, in the strains of bw_piece_strains: S = A + σM and B
  !! with M = BᵀB. Rows of B are the coefficients of √(mL) v and √(ρIL) ψ in each piece, for a tapering piece times the factor C
  !! of the weight, W = CᵀC, and √m_b v and √J ψ of the bodies. All is exact, as tension and sections are polynomials.
  !!
  !! The modes' equation is A x = β²M x. In plane A = K − Ω²(mass of v), out of plane A = K − Ω²(inertia of ψ), K with the tension.
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_lapack, only: dpbtrf
  use bw_missing, only: no_number
  use bw_piece_strains, only: columns_of, ends_of, forces_on, layout_of, motions_of, piece_forces, piece_motions, strain_layout
  use bw_strain_basis, only: times_polynomial
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: build_system, forms_of_spin, stressed, turn_of_piece, unfactored

  type, public :: strain_system
    type(strain_layout) :: layout
    real(dp), allocatable :: stiffness(:, :)       !! S, (unknowns, unknowns)
    real(dp), allocatable :: mass_root(:, :)       !! B, (rows, unknowns)
  end type strain_system

  type :: part_weights
    !! Weights of the terms of a quadratic form.
    real(dp) :: elastic = 0.0_dp
    real(dp) :: tension = 0.0_dp                   !! ∫Tv'²/Ω²
    real(dp) :: deflection = 0.0_dp                !! ∫mv² and bodies' masses
    real(dp) :: turning = 0.0_dp                   !! ∫ρIψ²
    real(dp) :: inertia = 0.0_dp                   !! bodies' inertias
  end type part_weights

contains

  subroutine build_system(given, functions, shift, system)
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: functions(:)            !! of each strain in a piece, ≥ 3, (pieces)
    type(dd), intent(in) :: shift                  !! σ
    type(strain_system), intent(out) :: system
    type(part_weights) :: weights
    associate (square => given%beam%spin_squared, in_plane => given%beam%in_plane)
      weights = part_weights(elastic=1.0_dp, tension=square%hi, deflection=shift%hi, turning=shift%hi, inertia=shift%hi)
      if (in_plane) weights%deflection = shift%hi - square%hi
      if (.not. in_plane) weights%turning = shift%hi - square%hi
    end associate
    system%layout = layout_of(given%beam, functions)
    call build_form(given, system%layout, weights, system%stiffness)
    call build_mass_root(given, system%layout, system%mass_root)
    if (given%beam%root%on_hub) call add_turn(shift%hi, system)
  end subroutine build_system

  pure subroutine add_turn(shift, system)
    !! Add the rotation of a free hub, which has no stiffness: the last row and column are those of σM.
    real(dp), intent(in) :: shift                  !! σ
    type(strain_system), intent(inout) :: system
    real(dp), allocatable :: form(:, :)
    integer :: n
    n = size(system%stiffness, 1)
    allocate (form(n + 1, n + 1))
    form(:n, :n) = system%stiffness
    form(n + 1, :) = shift*matmul(system%mass_root(:, n + 1), system%mass_root)
    form(:n, n + 1) = form(n + 1, :n)
    call move_alloc(form, system%stiffness)
  end subroutine add_turn

  pure function turn_of_piece(given, i, n) result(motion)
    !! Return the coefficients of the deflection R + ξ over a piece, for a hub rotation of 1.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: i
    integer, intent(in) :: n                       !! ≥ 2
    real(dp) :: motion(n)
    associate (piece => given%beam%piece)
      motion = 0.0_dp
      motion(1) = given%beam%root%hub_radius%hi + sum(piece(:i - 1)%length%hi) + 0.5_dp*piece(i)%length%hi
      motion(2) = piece(i)%length%hi*sqrt(3.0_dp)/6.0_dp
    end associate
  end function turn_of_piece

  subroutine forms_of_spin(given, functions, elastic, tension, push)
    !! Build the matrices of the mode equation at any speed: A = K + Ω²(T − R), with elastic stiffness, stiffness due to
    !! tension, and that due to the centrifugal force.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: functions(:)
    real(dp), allocatable, dimension(:, :), intent(out) :: elastic, tension, push      !! K, T, R, (unknowns, unknowns)
    type(strain_layout) :: layout
    layout = layout_of(given%beam, functions)
    call build_form(given, layout, part_weights(elastic=1.0_dp), elastic)
    call build_form(given, layout, part_weights(tension=1.0_dp), tension)
    if (given%beam%in_plane) then
      call build_form(given, layout, part_weights(deflection=1.0_dp), push)
    else
      call build_form(given, layout, part_weights(turning=1.0_dp), push)
    end if
  end subroutine forms_of_spin

  ! Quadratic forms

  pure subroutine build_form(given, layout, weights, form)
    type(varying_beam), intent(in) :: given
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
    !! Return the part of a piece in a form, for the unknowns that move it, in the order of `columns_of`.
    type(varying_beam), intent(in) :: given
    type(strain_layout), intent(in) :: layout
    type(part_weights), intent(in) :: weights
    integer, intent(in) :: i
    real(dp), allocatable :: part(:, :)
    real(dp), allocatable :: unit(:, :), force(:)
    type(piece_motions) :: motion
    integer :: j, joints
    unit = unit_columns(layout, i)
    joints = size(unit, 2) - (size(unit, 1) - 4)
    motion = motions_of(given%beam%piece(i), layout%functions(i), layout%shear, unit)
    allocate (part(size(unit, 2), size(unit, 2)), force(size(unit, 1)))
    do j = 1, size(unit, 2)
      force = forces_on(given%beam%piece(i), layout%functions(i), layout%shear, forces_of(given, weights, i, motion, j))
      part(:joints, j) = matmul(force(:4), unit(:4, :joints))
      part(joints + 1:, j) = force(5:)
    end do
  end function part_of_piece

  pure type(piece_forces) function forces_of(given, weights, i, motion, j) result(force)
    !! Return the forces of a form on the motions of column j in a piece.
    type(varying_beam), intent(in) :: given
    type(part_weights), intent(in) :: weights
    integer, intent(in) :: i
    type(piece_motions), intent(in) :: motion
    integer, intent(in) :: j
    associate (piece => given%beam%piece(i), law => given%law(i), n => size(motion%turning, 1) - 1)
      force%strain = 0.0_dp*motion%strain(:, j)
      if (weights%elastic > 0.0_dp) force%strain = weights%elastic*stressed(law%stiffness, law%shear, n, motion%strain(:, j))
      force%slope = 0.0_dp*motion%slope(:, j)
      if (weights%tension /= 0.0_dp) force%slope = &
        weights%tension*piece%length%hi*times_polynomial(given%tension(i), motion%slope(:, j))
      force%turning = 0.0_dp*motion%turning(:, j)
      if (weights%turning*piece%rotary%hi /= 0.0_dp) force%turning = &
        weights%turning*piece%rotary%hi*piece%length%hi*times_polynomial(law%rotary, motion%turning(:, j))
      force%deflection = 0.0_dp*motion%deflection(:, j)
      if (weights%deflection /= 0.0_dp) force%deflection = &
        weights%deflection*piece%mass%hi*piece%length%hi*times_polynomial(law%mass, motion%deflection(:, j))
    end associate
  end function forces_of

  pure function unit_columns(layout, i) result(unit)
    !! Return unit columns for the unknowns that move a piece: ends and strains inside, (4 + inside, columns).
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
  end function unit_columns

  pure function stressed(stiffness, shear, n, strain) result(stress)
    !! Return stresses, strains of a piece times the local stiffness.
    real(dp), intent(in) :: stiffness(:), shear(:)     !! laws of EI and κGA
    integer, intent(in) :: n                           !! number of curvatures, followed by shear strains
    real(dp), intent(in) :: strain(:)
    real(dp) :: stress(size(strain))
    stress(:n) = times_polynomial(stiffness, strain(:n))
    if (size(strain) > n) stress(n + 1:) = times_polynomial(shear, strain(n + 1:))
  end function stressed

  ! Mass

  subroutine build_mass_root(given, layout, root)
    type(varying_beam), intent(in) :: given
    type(strain_layout), intent(in) :: layout
    real(dp), allocatable, intent(out) :: root(:, :)   !! (rows, unknowns)
    type(piece_motions) :: unit
    integer, allocatable :: column(:)
    integer :: i, n, row, last
    real(dp) :: turn(maxval(layout%functions) + 2, 1)
    associate (beam => given%beam)
      n = size(beam%piece)
      last = layout%unknowns + merge(1, 0, beam%root%on_hub)
      allocate (root(2*sum(layout%functions + 2) + 2*n + 1, last), source=0.0_dp)
      row = 0
      do i = 1, n
        column = columns_of(layout, i)
        unit = motions_of(beam%piece(i), layout%functions(i), layout%shear, unit_columns(layout, i))
        associate (piece => beam%piece(i), law => given%law(i), f => layout%functions(i))
          root(row + 1:row + f + 2, column) = sqrt(piece%mass%hi*piece%length%hi)*factored(law%mass, unit%deflection)
          if (beam%root%on_hub) then
            turn(:f + 2, 1) = turn_of_piece(given, i, f + 2)
            root(row + 1:row + f + 2, last:) = sqrt(piece%mass%hi*piece%length%hi)*factored(law%mass, turn(:f + 2, :))
          end if
          row = row + f + 2
          if (piece%rotary%hi > 0.0_dp) then
            root(row + 1:row + f + 1, column) = sqrt(piece%rotary%hi*piece%length%hi)*factored(law%rotary, unit%turning)
            if (beam%root%on_hub) then
              turn(:, 1) = 0.0_dp
              turn(1, 1) = 1.0_dp
              root(row + 1:row + f + 1, last:) = sqrt(piece%rotary%hi*piece%length%hi)*factored(law%rotary, turn(:f + 1, :))
            end if
            row = row + f + 1
          end if
        end associate
      end do
      do i = 1, n
        call add_body(beam%joint(i)%mass%hi, layout%joints%deflection(:layout%joints%number, i), &
                      beam%root%hub_radius%hi + sum(beam%piece(:i)%length%hi))
        call add_body(beam%joint(i)%inertia%hi, layout%joints%turning(:layout%joints%number, i), 1.0_dp)
      end do
      if (beam%root%on_hub) then
        row = row + 1
        root(row, last) = sqrt(beam%root%hub_inertia%hi)
      end if
      root = root(:max(row, last), :)
    end associate
  contains
    subroutine add_body(inertia, motion, turn)
      real(dp), intent(in) :: inertia, motion(:)
      real(dp), intent(in) :: turn                   !! displacement per hub rotation
      if (inertia == 0.0_dp) return
      row = row + 1
      root(row, layout%of_joints) = sqrt(inertia)*motion
      if (given%beam%root%on_hub) root(row, last) = sqrt(inertia)*turn
    end subroutine add_body
  end subroutine build_mass_root

  function factored(law, f) result(g)
    !! Return C f, where ∫w f² = |C f|² for a weight w.
    real(dp), intent(in) :: law(:)
    real(dp), intent(in) :: f(:, :)                    !! coefficients, (functions, columns)
    real(dp) :: g(size(f, 1), size(f, 2))
    real(dp), allocatable :: c(:, :)
    integer :: d, j, n
    g = f
    if (size(law) == 1) return
    n = size(f, 1)
    call factor_weight(law, n, c)
    do j = 1, n
      g(j, :) = c(1, j)*f(j, :)
      do d = 1, min(size(law) - 1, n - j)
        g(j, :) = g(j, :) + c(d + 1, j)*f(j + d, :)
      end do
    end do
  end function factored

  function unfactored(law, g) result(f)
    !! Return f for g = C f.
    real(dp), intent(in) :: law(:)
    real(dp), intent(in) :: g(:, :)                    !! (functions, columns)
    real(dp) :: f(size(g, 1), size(g, 2))
    real(dp), allocatable :: c(:, :)
    integer :: d, j, n
    f = g
    if (size(law) == 1) return
    n = size(g, 1)
    call factor_weight(law, n, c)
    do j = n, 1, -1
      f(j, :) = g(j, :)
      do d = 1, min(size(law) - 1, n - j)
        f(j, :) = f(j, :) - c(d + 1, j)*f(j + d, :)
      end do
      f(j, :) = f(j, :)/c(1, j)
    end do
  end function unfactored

  subroutine factor_weight(law, n, c)
    !! Return the Cholesky factor of the matrix ∫w p_i p_j in lower band storage: Cᵀ_{j+d,j} is c(d + 1, j).
    real(dp), intent(in) :: law(:)                     !! w > 0
    integer, intent(in) :: n
    real(dp), allocatable, intent(out) :: c(:, :)      !! (size(law), n)
    real(dp) :: unit(n)
    integer :: d, info, j
    allocate (c(size(law), n), source=0.0_dp)
    do j = 1, n
      unit = 0.0_dp
      unit(j) = 1.0_dp
      unit = times_polynomial(law, unit)
      d = min(size(law), n - j + 1)
      c(:d, j) = unit(j:j + d - 1)
    end do
    call dpbtrf('L', n, size(law) - 1, c, size(law), info)
    if (info /= 0) c = no_number()                     ! then the system has no factor, either
  end subroutine factor_weight

end module bw_strain_system
