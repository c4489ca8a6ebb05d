module bw_extended_stiffness
  !! The dynamic stiffness of a beam of pieces in binary128, for modes that binary64 does not tell apart, and how many modes lie
  !! below a frequency.
  !!
  !! A piece answers even motions of its ends, e = (d + Dd')/2, and odd ones, o = (d − Dd')/2, each by itself: d = (v, ψ) at the
  !! outer, d' at the inner end, D = diag(1, −1). The joints are let go one by one from the root, and the pivots' negative
  !! eigenvalues are counted (Wittrick and Williams, bw_mode_count).
  use bw_double_double, only: dd, to_quad, operator(-), operator(*)
  use bw_extended_ends, only: extended_ends, hinged_below
  use bw_kinds, only: dp, qp
  use bw_mode_probe, only: piece_system
  use bw_piece_beam, only: beam_joint, beam_root
  use bw_piece_waves, only: piece_frequency
  implicit none (type, external)
  private
  public :: size_stiffness, find_stiffness, inverse, times

  type, public :: extended_stiffness
    type(dd), allocatable :: outer(:, :, :)        !! states at the outer ends of the motions of each piece, (4, 4, n)
    real(qp), allocatable :: even(:, :, :)         !! forces N and M for e, (2, 2, n)
    real(qp), allocatable :: odd(:, :, :)          !! and for o, (2, 2, n)
    real(qp), allocatable :: link(:, :, :)         !! forces at the outer end for motion of the inner end, (2, 2, n)
    real(qp), allocatable :: own(:, :, :)          !! forces at each joint for its own motion, (2, 2, 0:n)
    real(qp), allocatable :: motion(:, :)          !! v and ψ of the joints, (2, 0:n)
    integer :: below = 0                           !! modes below the frequency
    real(qp) :: regular = 1.0_qp                   !! distance of the frequency from clamped modes of the pieces, 0 … 1
  end type extended_stiffness

contains

  pure subroutine size_stiffness(n, stiffness)
    integer, intent(in) :: n                       !! pieces
    type(extended_stiffness), intent(out) :: stiffness
    allocate (stiffness%outer(4, 4, n), stiffness%even(2, 2, n), stiffness%odd(2, 2, n), stiffness%own(2, 2, 0:n))
    allocate (stiffness%link(2, 2, n), stiffness%motion(2, 0:n))
  end subroutine size_stiffness

  pure subroutine find_stiffness(system, frequency, stiffness)
    type(piece_system), intent(in) :: system
    type(piece_frequency), intent(in) :: frequency
    type(extended_stiffness), intent(inout) :: stiffness
    integer :: i, n
    n = size(system%piece)
    stiffness%below = 0
    stiffness%regular = 1.0_qp
    stiffness%own(:, :, 0) = root_springs(system%beam%root)
    do i = 1, n
      call find_piece(system, frequency, i, stiffness)
      stiffness%own(:, :, i) = load_of(system%beam%joint(i), frequency)
    end do
    do i = 1, n
      stiffness%own(:, :, i) = stiffness%own(:, :, i) + outer_block(stiffness, i)
      stiffness%own(:, :, i - 1) = stiffness%own(:, :, i - 1) + inner_block(stiffness, i)
    end do
    call hold_root(system%beam%root, stiffness%own(:, :, 0), stiffness%link(:, :, 1))
    call count_negatives(stiffness)
  end subroutine find_stiffness

  pure subroutine count_negatives(stiffness)
    !! Let the joints go from the root outwards.
    type(extended_stiffness), intent(inout) :: stiffness
    real(qp) :: pivot(2, 2), link(2, 2)
    integer :: i
    pivot = stiffness%own(:, :, 0)
    do i = 0, ubound(stiffness%own, 3)
      if (i > 0) then
        link = stiffness%link(:, :, i)
        pivot = stiffness%own(:, :, i) - product_of(product_of(link, inverse(pivot)), transpose(link))
      end if
      stiffness%below = stiffness%below + negative_eigenvalues(pivot)
    end do
  end subroutine count_negatives

  pure subroutine find_piece(system, frequency, i, stiffness)
    type(piece_system), intent(in) :: system
    type(piece_frequency), intent(in) :: frequency
    integer, intent(in) :: i
    type(extended_stiffness), intent(inout) :: stiffness
    real(qp) :: f(4, 4)
    associate (even => stiffness%even(:, :, i), odd => stiffness%odd(:, :, i))
      stiffness%outer(:, :, i) = extended_ends(system%piece(i), frequency)
      f = to_quad(stiffness%outer(:, :, i))
      call find_parity(f(:, 1:2), even, stiffness%regular)
      call find_parity(f(:, 3:4), odd, stiffness%regular)
      stiffness%below = stiffness%below + hinged_below(system%piece(i), frequency) &
        - count([even(2, 2), odd(2, 2)] < 0.0_qp)
      stiffness%link(:, :, i) = outer_link(even, odd)
    end associate
  end subroutine find_piece

  pure subroutine find_parity(f, k, regular)
    !! Forces (N, M) that two motions of one parity take for (v, ψ) at the outer end.
    real(qp), intent(in) :: f(4, 2)                !! (v, ψ, M, N) of the motions
    real(qp), intent(out) :: k(2, 2)
    real(qp), intent(inout) :: regular
    real(qp) :: one, other, det
    one = f(1, 1)*f(2, 2)
    other = f(1, 2)*f(2, 1)
    det = one - other
    regular = min(regular, abs(det)/(abs(one) + abs(other)))
    if (det == 0.0_qp) det = tiny(1.0_dp)
    k(:, 1) = (f([4, 3], 1)*f(2, 2) - f([4, 3], 2)*f(2, 1))/det
    k(:, 2) = (f([4, 3], 2)*f(1, 1) - f([4, 3], 1)*f(1, 2))/det
  end subroutine find_parity

  pure function outer_block(stiffness, i) result(k)
    !! Forces at the outer end of piece i for its motion there.
    type(extended_stiffness), intent(in) :: stiffness
    integer, intent(in) :: i
    real(qp) :: k(2, 2)
    k = 0.5_qp*(stiffness%even(:, :, i) + stiffness%odd(:, :, i))
  end function outer_block

  pure function inner_block(stiffness, i) result(k)
    !! Likewise at the inner end.
    type(extended_stiffness), intent(in) :: stiffness
    integer, intent(in) :: i
    real(qp) :: k(2, 2)
    k = outer_block(stiffness, i)
    k(1, 2) = -k(1, 2)
    k(2, 1) = -k(2, 1)
  end function inner_block

  pure function outer_link(even, odd) result(k)
    real(qp), intent(in) :: even(2, 2), odd(2, 2)
    real(qp) :: k(2, 2)
    k = 0.5_qp*(even - odd)
    k(:, 2) = -k(:, 2)
  end function outer_link

  pure function load_of(joint, frequency) result(k)
    !! Forces of what is attached.
    type(beam_joint), intent(in) :: joint
    type(piece_frequency), intent(in) :: frequency
    real(qp) :: k(2, 2)
    k = 0.0_qp
    k(1, 1) = to_quad(joint%stiffness - joint%mass*frequency%lambda)
    k(2, 2) = to_quad(joint%turning_stiffness - joint%inertia*frequency%beta_squared)
  end function load_of

  pure function root_springs(root) result(k)
    type(beam_root), intent(in) :: root
    real(qp) :: k(2, 2)
    k = 0.0_qp
    k(1, 1) = to_quad(root%stiffness)
    k(2, 2) = to_quad(root%turning_stiffness)
  end function root_springs

  pure subroutine hold_root(root, own, link)
    !! What is held takes part no more.
    type(beam_root), intent(in) :: root
    real(qp), intent(inout) :: own(2, 2), link(2, 2)
    logical :: held(2)
    integer :: j
    held = [root%holds_deflection, root%holds_turning]
    do j = 1, 2
      if (.not. held(j)) cycle
      own(j, :) = 0.0_qp
      own(:, j) = 0.0_qp
      own(j, j) = 1.0_qp
      link(:, j) = 0.0_qp
    end do
  end subroutine hold_root

  pure integer function negative_eigenvalues(k) result(number)
    real(qp), intent(in) :: k(2, 2)
    number = 0
    if (k(1, 1)*k(2, 2) < k(1, 2)*k(2, 1)) then
      number = 1
    else if (k(1, 1) + k(2, 2) < 0.0_qp) then
      number = 2
    end if
  end function negative_eigenvalues

  pure function inverse(k)
    real(qp), intent(in) :: k(2, 2)
    real(qp) :: inverse(2, 2)
    real(qp) :: det
    det = k(1, 1)*k(2, 2) - k(1, 2)*k(2, 1)
    if (det == 0.0_qp) det = tiny(1.0_dp)
    inverse(:, 1) = [k(2, 2), -k(2, 1)]/det
    inverse(:, 2) = [-k(1, 2), k(1, 1)]/det
  end function inverse

  pure function times(k, d) result(f)
    real(qp), intent(in) :: k(2, 2), d(2)
    real(qp) :: f(2)
    f = k(:, 1)*d(1) + k(:, 2)*d(2)
  end function times

  pure function product_of(a, b) result(c)
    real(qp), intent(in) :: a(2, 2), b(2, 2)
    real(qp) :: c(2, 2)
    c(:, 1) = times(a, b(:, 1))
    c(:, 2) = times(a, b(:, 2))
  end function product_of

end module bw_extended_stiffness
