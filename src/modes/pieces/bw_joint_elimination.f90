module bw_joint_elimination
  !! Amplitudes of all pieces from the conditions at their joints, by elimination from the root outwards.
  !!
  !! The conditions on the inner side leave two of a piece's four motions free. At its outer joint deflection and
  !! rotation are continuous, and moment and shear force jump by the forces of attachments: four conditions on these two
  !! and on the next piece's four, of which two remain for the latter. The matrix of all conditions has no poles; at a
  !! mode it is singular, and solving with any right side gives the mode (inverse iteration). Rows are divided by their
  !! largest elements, the largest element is the pivot, and the time is proportional to the number of pieces.
  use bw_kinds, only: dp
  use bw_piece_beam, only: beam_root
  use bw_piece_ends, only: inner_states, parity_shares, piece_ends
  implicit none (type, external)
  private
  public :: eliminate, solve, size_elimination

  integer, parameter :: width = 8
    !! of a condition: two shares, four amplitudes of the next piece, right side, and padding to a register
  real(dp), parameter :: least_pivot = 1.0e-17_dp  !! in rows of size 1; below it is rounding

  type, public :: joint_loads
    !! Dynamic stiffness of attachments to deflection and to rotation: k_v − m_bλ and k_θ − J_bβ².
    real(dp) :: deflection = 0.0_dp
    real(dp) :: turning = 0.0_dp
    logical :: inside = .false.                  !! they move with the piece before; else with the piece after, or with the root
  end type joint_loads

  type, public :: elimination
    real(dp), allocatable :: free(:, :, :)       !! amplitudes of the two free motions of each piece, (4, 2, n)
    real(dp), allocatable :: forced(:, :)        !! amplitudes due to the right sides, (4, n)
    real(dp), allocatable :: state(:, :, :)      !! v, ψ, M and N of the free motions at the outer end, (4, 2, n)
    real(dp), allocatable :: next(:, :, :)       !! shares of the free motions by amplitudes of the next piece, (4, 2, n)
    real(dp), allocatable :: share(:, :)         !! shares due to the right sides, (2, n)
    real(dp), allocatable :: second(:)           !! share of the first motion by that of the second, (n)
  end type elimination

contains

  pure subroutine size_elimination(n, factors)
    integer, intent(in) :: n                     !! pieces
    type(elimination), intent(out) :: factors
    allocate (factors%free(4, 2, n), factors%forced(4, n), factors%state(4, 2, n), factors%next(4, 2, n), factors%share(2, n))
    allocate (factors%second(n))
  end subroutine size_elimination

  pure subroutine eliminate(root, loads, ends, right, factors)
    type(beam_root), intent(in) :: root
    type(joint_loads), intent(in) :: loads(0:)   !! (0:n); at 0 the springs of the root
    type(piece_ends), intent(in) :: ends(:)      !! (n)
    real(dp), intent(in) :: right(:, 0:)         !! right side of each condition, (4, 0:n)
    type(elimination), intent(inout) :: factors  !! allocated for n pieces
    real(dp) :: condition(4, 2), rest(2), row(width, 4), forced(4)
    integer :: i, n
    n = size(ends)
    call set_root(root, loads(0), inner_states(ends(1)), right(:, 0), condition, rest)
    do i = 1, n
      call solve_conditions(condition, rest, factors%free(:, :, i), factors%forced(:, i))
      forced = product_of(ends(i)%outer, parity_shares(ends(i), factors%forced(:, i)))
      associate (state => factors%state(:, :, i), free => factors%free(:, :, i))
        state(:, 1) = product_of(ends(i)%outer, parity_shares(ends(i), free(:, 1)))
        state(:, 2) = product_of(ends(i)%outer, parity_shares(ends(i), free(:, 2)))
        row(1, :) = state(:, 1)
        row(2, :) = state(:, 2)
      end associate
      row(7, :) = right(:, i) - forced
      if (i < n) then
        call set_joint(loads(i), inner_states(ends(i + 1)), forced, row)
        call eliminate_shares(4, row)
        condition = row(3:6, 3:4)
        rest = row(7, 3:4)
      else
        call set_tip(loads(n), right(:, n), forced, row)
        call eliminate_shares(2, row)
      end if
      call keep_shares(row, factors%next(:, :, i), factors%share(:, i), factors%second(i))
    end do
  end subroutine eliminate

  pure subroutine set_root(root, load, inner, right, condition, rest)
    !! Set the conditions at the root: v = 0 or N = k_v v; ψ = 0 or M = k_θψ.
    type(beam_root), intent(in) :: root
    type(joint_loads), intent(in) :: load
    real(dp), intent(in) :: inner(4, 4)          !! (motion, state)
    real(dp), intent(in) :: right(4)
    real(dp), intent(out) :: condition(4, 2), rest(2)
    if (root%holds_deflection) then
      condition(:, 1) = -inner(:, 1)
    else
      condition(:, 1) = load%deflection*inner(:, 1) - inner(:, 4)
    end if
    if (root%holds_turning) then
      condition(:, 2) = -inner(:, 2)
    else
      condition(:, 2) = load%turning*inner(:, 2) - inner(:, 3)
    end if
    rest = [right(merge(1, 4, root%holds_deflection)), right(merge(2, 3, root%holds_turning))]
  end subroutine set_root

  pure function product_of(outer, amplitude) result(state)
    !! Return the state at the outer end of a piece.
    real(dp), intent(in) :: outer(4, 4), amplitude(4)
    real(dp) :: state(4)
    state = outer(:, 1)*amplitude(1) + outer(:, 2)*amplitude(2) + outer(:, 3)*amplitude(3) + outer(:, 4)*amplitude(4)
  end function product_of

  pure subroutine set_joint(load, after, forced, row)
    !! Set the conditions at a joint: differences between the piece before and the piece after, of v, ψ, and of M and N
    !! with attachments. These move with the shorter piece, whose end motions have all digits; in a long piece they have
    !! those of its waves.
    type(joint_loads), intent(in) :: load
    real(dp), intent(in) :: after(4, 4)          !! states of the piece after, (motion, state)
    real(dp), intent(in) :: forced(4)            !! state of the piece before due to the right sides
    real(dp), intent(inout) :: row(width, 4)
    integer :: q
    row(3:6, :) = -after
    if (load%inside) then
      row(1:2, 3) = row(1:2, 3) + load%turning*row(1:2, 2)
      row(1:2, 4) = row(1:2, 4) + load%deflection*row(1:2, 1)
      row(7, 3:4) = row(7, 3:4) - [load%turning*forced(2), load%deflection*forced(1)]
    else
      row(3:6, 3) = row(3:6, 3) + load%turning*after(:, 2)
      row(3:6, 4) = row(3:6, 4) + load%deflection*after(:, 1)
    end if
    row(8, :) = 0.0_dp
    do q = 1, 4
      call divide_row(row(:, q))
    end do
  end subroutine set_joint

  pure subroutine set_tip(load, right, forced, row)
    !! Set the two conditions at the tip: no moment and no shear force besides those of attachments.
    type(joint_loads), intent(in) :: load
    real(dp), intent(in) :: right(4), forced(4)
    real(dp), intent(inout) :: row(width, 4)
    real(dp) :: v(2)
    v = row(1:2, 1)
    row(1:2, 1) = row(1:2, 3) + load%turning*row(1:2, 2)
    row(1:2, 2) = row(1:2, 4) + load%deflection*v
    row(7, 1:2) = right(3:4) - forced(3:4) - [load%turning*forced(2), load%deflection*forced(1)]
    row(3:6, 1:2) = 0.0_dp
    row(8, 1:2) = 0.0_dp
    call divide_row(row(:, 1))
    call divide_row(row(:, 2))
  end subroutine set_tip

  pure subroutine divide_row(row)
    !! Divide a row by its largest element.
    real(dp), intent(inout) :: row(width)
    row = row*(1.0_dp/max(max(abs(row(1)), abs(row(2)), abs(row(3))), max(abs(row(4)), abs(row(5)), abs(row(6)))))
  end subroutine divide_row

  pure subroutine solve_conditions(condition, rest, free, forced)
    !! Find two independent solutions of two conditions on four amplitudes, and one with the right sides. The second
    !! condition is made independent of the first, as the two would become parallel from piece to piece.
    real(dp), intent(in) :: condition(4, 2), rest(2)
    real(dp), intent(out) :: free(4, 2), forced(4)
    real(dp) :: a(4), b(4), sides(2)
    integer :: first, second, i, n
    a = condition(:, 1)/largest(condition(:, 1))
    b = condition(:, 2)/largest(condition(:, 2))
    sides = rest/[largest(condition(:, 1)), largest(condition(:, 2))]
    first = place_of_largest(a)
    sides(1) = sides(1)/a(first)
    a = a/a(first)
    sides(2) = sides(2) - b(first)*sides(1)
    b = b - b(first)*a
    b(first) = 0.0_dp
    second = place_of_largest(b)
    if (abs(b(second)) < least_pivot) then       ! the inner part moves alone: any condition serves
      second = mod(first, 4) + 1
      b(second) = least_pivot
    end if
    sides(2) = sides(2)/b(second)
    b = b/b(second)
    sides(1) = sides(1) - a(second)*sides(2)
    a = a - a(second)*b
    forced = 0.0_dp
    forced(first) = sides(1)
    forced(second) = sides(2)
    free = 0.0_dp
    n = 0
    do i = 1, 4
      if (i == first .or. i == second) cycle
      n = n + 1
      free(i, n) = 1.0_dp
      free(first, n) = -a(i)
      free(second, n) = -b(i)
    end do
  end subroutine solve_conditions

  pure real(dp) function largest(values)
    real(dp), intent(in) :: values(4)
    largest = max(abs(values(1)), abs(values(2)), abs(values(3)), abs(values(4)))
  end function largest

  pure integer function place_of_largest(values) result(place)
    real(dp), intent(in) :: values(4)
    integer :: i
    place = 1
    do i = 2, 4
      if (abs(values(i)) > abs(values(place))) place = i
    end do
  end function place_of_largest

  pure subroutine eliminate_shares(conditions, row)
    !! Eliminate the shares of the two free motions from the conditions; rows 1 and 2 then form a triangle.
    integer, intent(in) :: conditions
    real(dp), intent(inout) :: row(width, 4)
    real(dp) :: pivot(width)
    integer :: c, j, place
    do c = 1, 2
      place = c
      do j = c + 1, conditions
        if (abs(row(c, j)) > abs(row(c, place))) place = j
      end do
      pivot = row(:, place)
      row(:, place) = row(:, c)
      if (abs(pivot(c)) < least_pivot) pivot(c) = sign(least_pivot, pivot(c))
      row(:, c) = pivot
      do j = c + 1, conditions
        row(:, j) = row(:, j) - (row(c, j)/pivot(c))*pivot
      end do
    end do
  end subroutine eliminate_shares

  pure subroutine keep_shares(row, next, share, second)
    !! Store shares = share − Σ next·(amplitudes of the next piece) from the triangle; the first less `second` times the second.
    real(dp), intent(in) :: row(width, 4)
    real(dp), intent(out) :: next(4, 2), share(2), second
    real(dp) :: factor
    factor = 1.0_dp/row(2, 2)
    next(:, 2) = row(3:6, 2)*factor
    share(2) = row(7, 2)*factor
    factor = 1.0_dp/row(1, 1)
    next(:, 1) = row(3:6, 1)*factor
    share(1) = row(7, 1)*factor
    second = row(2, 1)*factor
  end subroutine keep_shares

  pure subroutine solve(factors, ends, amplitude)
    !! Substitute back from the tip to the root.
    type(elimination), intent(in) :: factors
    type(piece_ends), intent(in) :: ends(:)      !! (n)
    real(dp), intent(out) :: amplitude(:, :)     !! (4, n)
    real(dp) :: share(2), next(4)
    integer :: i
    next = 0.0_dp                                ! nothing beyond the tip
    do i = size(amplitude, 2), 1, -1
      share(2) = factors%share(2, i) - sum(factors%next(:, 2, i)*next)
      share(1) = factors%share(1, i) - sum(factors%next(:, 1, i)*next) - factors%second(i)*share(2)
      next = factors%forced(:, i) + share(1)*factors%free(:, 1, i) + share(2)*factors%free(:, 2, i)
      amplitude(:, i) = parity_shares(ends(i), next)
    end do
  end subroutine solve

end module bw_joint_elimination
