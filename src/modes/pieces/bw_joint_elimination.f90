module bw_joint_elimination
  !! Amplitudes of all pieces from the conditions at their joints, by elimination from the root outwards.
  !!
  !! Unknown are the amplitudes of the four motions of each piece. At a joint deflection and turning are continuous, moment
  !! and shear force jump by what is attached there: four conditions on eight amplitudes; the root and the tip give two
  !! each. The matrix has no poles; where a mode is, it is singular. Its rows are divided by their largest elements, rows
  !! are exchanged as they are eliminated, and a solution takes time in proportion to the pieces. Solving with any right
  !! side near a mode gives the mode (inverse iteration).
  use bw_kinds, only: dp
  use bw_piece_beam, only: beam_root
  use bw_piece_ends, only: inner_row, piece_ends
  implicit none (type, external)
  private
  public :: eliminate, solve

  real(dp), parameter :: least_pivot = 1.0e-17_dp  !! of rows of size 1: below it is rounding

  type, public :: joint_loads
    !! Forces of what is attached, for deflection and for turning: k_v − m_bλ and k_θ − J_bβ².
    real(dp) :: deflection = 0.0_dp
    real(dp) :: turning = 0.0_dp
  end type joint_loads

  type, public :: elimination
    real(dp), allocatable :: inside(:, :, :)     !! two conditions on each piece from all that is inside of it, (4, 2, n)
    real(dp), allocatable :: upper(:, :, :)      !! rows of the triangle: each piece and the next, (8, 4, n)
    real(dp), allocatable :: right(:, :)         !! their right sides, (4, n)
    real(dp), allocatable :: row_size(:, :)      !! what rows were divided by, (4, 0:n): of v, ψ, M, N at each joint
  end type elimination

  type :: panel_type
    !! Six conditions on a piece and the next.
    real(dp) :: row(8, 6) = 0.0_dp
    real(dp) :: right(6) = 0.0_dp
  end type panel_type

contains

  pure subroutine eliminate(root, loads, ends, right, factors)
    type(beam_root), intent(in) :: root
    type(joint_loads), intent(in) :: loads(0:)   !! (0:n); at 0 the springs of the root
    type(piece_ends), intent(in) :: ends(:)      !! (n)
    real(dp), intent(in) :: right(:, 0:)         !! right side of each condition, (4, 0:n)
    type(elimination), intent(inout) :: factors  !! allocated for n pieces
    type(panel_type) :: panel
    integer :: i, n
    n = size(ends)
    call set_root(root, loads(0), ends(1), right(:, 0), panel, factors%row_size(:, 0))
    do i = 1, n
      call part(panel%row, panel%right)
      factors%inside(:, :, i) = panel%row(1:4, 1:2)
      if (i < n) then
        call set_joint(loads(i), ends(i), ends(i + 1), right(:, i), panel, factors%row_size(:, i))
        call eliminate_piece(6, panel%row, panel%right)
      else
        call set_tip(loads(n), ends(n), right(:, n), panel, factors%row_size(:, n))
        call eliminate_piece(4, panel%row, panel%right)
      end if
      factors%upper(:, :, i) = panel%row(:, 1:4)
      factors%right(:, i) = panel%right(1:4)
      panel%row(1:4, 1:2) = panel%row(5:8, 5:6)
      panel%row(5:8, 1:2) = 0.0_dp
      panel%right(1:2) = panel%right(5:6)
    end do
  end subroutine eliminate

  pure subroutine set_root(root, load, first, right, panel, row_size)
    !! v = 0 or N = k_v v; ψ = 0 or M = k_θψ: the first two rows.
    type(beam_root), intent(in) :: root
    type(joint_loads), intent(in) :: load
    type(piece_ends), intent(in) :: first
    real(dp), intent(in) :: right(4)
    type(panel_type), intent(inout) :: panel
    real(dp), intent(out) :: row_size(4)
    integer :: v, psi
    v = merge(1, 4, root%holds_deflection)
    psi = merge(2, 3, root%holds_turning)
    row_size = 1.0_dp
    if (root%holds_deflection) then
      panel%row(1:4, 1) = -inner_row(first, 1)
    else
      panel%row(1:4, 1) = load%deflection*inner_row(first, 1) - inner_row(first, 4)
    end if
    if (root%holds_turning) then
      panel%row(1:4, 2) = -inner_row(first, 2)
    else
      panel%row(1:4, 2) = load%turning*inner_row(first, 2) - inner_row(first, 3)
    end if
    call divide_row(panel%row(:, 1), row_size(v))
    call divide_row(panel%row(:, 2), row_size(psi))
    panel%right(1:2) = [right(v)/row_size(v), right(psi)/row_size(psi)]
  end subroutine set_root

  pure subroutine set_joint(load, before, after, right, panel, row_size)
    !! What the piece before has more than the piece after: v, ψ, and M and N with what is attached: rows 3 … 6. The body
    !! moves with the piece after: beside a load that is large the forces of the piece before keep their digits.
    type(joint_loads), intent(in) :: load
    type(piece_ends), intent(in) :: before, after
    real(dp), intent(in) :: right(4)
    type(panel_type), intent(inout) :: panel
    real(dp), intent(out) :: row_size(4)
    integer :: q
    do q = 1, 4
      panel%row(1:4, q + 2) = before%outer(q, :)
      panel%row(5:8, q + 2) = -inner_row(after, q)
    end do
    panel%row(5:8, 5) = panel%row(5:8, 5) + load%turning*inner_row(after, 2)
    panel%row(5:8, 6) = panel%row(5:8, 6) + load%deflection*inner_row(after, 1)
    do q = 1, 4
      call divide_row(panel%row(:, q + 2), row_size(q))
      panel%right(q + 2) = right(q)/row_size(q)
    end do
  end subroutine set_joint

  pure subroutine set_tip(load, last, right, panel, row_size)
    !! No moment and no shear force beyond what is attached: rows 3 and 4.
    type(joint_loads), intent(in) :: load
    type(piece_ends), intent(in) :: last
    real(dp), intent(in) :: right(4)
    type(panel_type), intent(inout) :: panel
    real(dp), intent(out) :: row_size(4)
    row_size = 1.0_dp
    panel%row(:, 3:4) = 0.0_dp
    panel%row(1:4, 3) = last%outer(3, :) + load%turning*last%outer(2, :)
    panel%row(1:4, 4) = last%outer(4, :) + load%deflection*last%outer(1, :)
    call divide_row(panel%row(:, 3), row_size(3))
    call divide_row(panel%row(:, 4), row_size(4))
    panel%right(3:4) = right(3:4)/row_size(3:4)
  end subroutine set_tip

  pure subroutine divide_row(row, row_size)
    !! By its largest element.
    real(dp), intent(inout) :: row(8)
    real(dp), intent(out) :: row_size
    row_size = max(max(abs(row(1)), abs(row(2)), abs(row(3)), abs(row(4))), &
                   max(abs(row(5)), abs(row(6)), abs(row(7)), abs(row(8))))
    row = row*(1.0_dp/row_size)
  end subroutine divide_row

  pure subroutine part(row, right)
    !! Take out of one of two conditions what the other says too, and make both of size 1: from piece to piece they would
    !! become parallel, and rows that became small would never be pivots.
    real(dp), intent(inout) :: row(8, 6), right(6)
    real(dp) :: row_size, factor
    integer :: c, i, j
    do j = 1, 2
      call divide_row(row(:, j), row_size)
      right(j) = right(j)/row_size
    end do
    c = 1
    do i = 2, 4
      if (abs(row(i, 1)) > abs(row(c, 1))) c = i
    end do
    factor = row(c, 2)/row(c, 1)
    row(:, 2) = row(:, 2) - factor*row(:, 1)
    row(c, 2) = 0.0_dp
    right(2) = right(2) - factor*right(1)
    i = mod(c, 4) + 1
    if (maxval(abs(row(:, 2))) < least_pivot) row(i, 2) = least_pivot     ! all inside moves alone: any condition serves
    call divide_row(row(:, 2), row_size)
    right(2) = right(2)/row_size
  end subroutine part

  pure subroutine eliminate_piece(m, row, right)
    !! Take the four amplitudes of a piece out of m rows; rows 1 … 4 are then the triangle's.
    integer, intent(in) :: m
    real(dp), intent(inout) :: row(8, 6), right(6)
    real(dp) :: pivot(8), pivot_right, factor
    integer :: c, i, j, place
    do c = 1, 4
      place = c
      do j = c + 1, m
        if (abs(row(c, j)) > abs(row(c, place))) place = j
      end do
      pivot = row(:, place)
      pivot_right = right(place)
      row(:, place) = row(:, c)
      right(place) = right(c)
      if (abs(pivot(c)) < least_pivot) pivot(c) = sign(least_pivot, pivot(c))
      row(:, c) = pivot
      right(c) = pivot_right
      do j = c + 1, m
        factor = row(c, j)/pivot(c)
        !GCC$ unroll 1
        do i = 1, 8          ! written out by the compiler it would leave vector registers
          row(i, j) = row(i, j) - factor*pivot(i)
        end do
        right(j) = right(j) - factor*pivot_right
      end do
    end do
  end subroutine eliminate_piece

  pure subroutine solve(factors, amplitude)
    !! From the tip back to the root.
    type(elimination), intent(in) :: factors
    real(dp), intent(out) :: amplitude(:, :)     !! (4, n)
    real(dp) :: rest(4), x(4), next(4)
    integer :: c, i, n
    n = size(amplitude, 2)
    next = 0.0_dp                                ! beyond the tip there is nothing
    do i = n, 1, -1
      do c = 1, 4
        rest(c) = factors%right(c, i) - sum(factors%upper(5:8, c, i)*next)
      end do
      x(4) = rest(4)/factors%upper(4, 4, i)
      x(3) = (rest(3) - factors%upper(4, 3, i)*x(4))/factors%upper(3, 3, i)
      x(2) = (rest(2) - sum(factors%upper(3:4, 2, i)*x(3:4)))/factors%upper(2, 2, i)
      x(1) = (rest(1) - sum(factors%upper(2:4, 1, i)*x(2:4)))/factors%upper(1, 1, i)
      amplitude(:, i) = x
      next = x
    end do
  end subroutine solve

end module bw_joint_elimination
