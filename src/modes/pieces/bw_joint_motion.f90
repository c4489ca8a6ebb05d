module bw_joint_motion
  !! How the joints of a beam of pieces move under forces, in binary128, and what its pieces then do. Elimination exchanges rows:
  !! far up, cantilevers and free beams share their frequencies, and two pivots of bw_extended_stiffness in a row may vanish.
  use bw_double_double, only: dd, to_quad
  use bw_extended_stiffness, only: extended_stiffness, inverse, times
  use bw_kinds, only: dp, qp
  implicit none (type, external)
  private
  public :: move_joints, amplitudes_of, stiffness_of

  integer, parameter :: width = 3                  !! of the band on both sides
  real(qp), parameter :: least_pivot = 1.0e-35_qp  !! of rows of size 1: below it is rounding

contains

  pure subroutine move_joints(force, unit, stiffness)
    !! How the joints move under forces.
    real(qp), intent(in) :: force(:, 0:)           !! N and M at each joint, 0 where the root is held, (2, 0:n)
    real(dp), intent(in) :: unit(:, 0:)            !! sizes of v and ψ at the joints, (2, 0:n)
    type(extended_stiffness), intent(inout) :: stiffness   !! as found
    real(qp) :: band(-width:2*width, 2*size(force, 2)), side(2*size(force, 2)), largest
    integer :: i, j, r, n
    n = ubound(force, 2)
    band = 0.0_qp
    do i = 0, n
      do j = 1, 2
        r = 2*i + j
        band(1 - j:2 - j, r) = stiffness%own(j, :, i)*unit(1:2, i)
        if (i > 0) band(-1 - j:-j, r) = stiffness%link(j, :, i)*unit(1:2, i - 1)
        if (i < n) band(3 - j:4 - j, r) = stiffness%link(:, j, i + 1)*unit(1:2, i + 1)
        largest = maxval(abs(band(:, r)))
        band(:, r) = band(:, r)/largest
        side(r) = force(j, i)/largest
      end do
    end do
    call solve_band(band, side)
    stiffness%motion = reshape(side, [2, n + 1])*unit(1:2, :)
  end subroutine move_joints

  pure subroutine solve_band(band, side)
    !! Elimination with exchange of rows; side becomes the solution. A matrix that is singular gives its null vector.
    real(qp), intent(inout) :: band(-width:, :)    !! element (r, r + d) at (d, r), (−w:2w, m)
    real(qp), intent(inout) :: side(:)             !! (m)
    real(qp) :: held, factor
    integer :: c, j, r, p, last, m
    m = size(side)
    do j = 1, m
      p = j
      do r = j + 1, min(j + width, m)
        if (abs(band(j - r, r)) > abs(band(j - p, p))) p = r
      end do
      last = min(j + 2*width, m)
      if (p /= j) then
        do c = j, last
          held = band(c - j, j)
          band(c - j, j) = merge(band(c - p, p), 0.0_qp, c - p <= 2*width)
          band(c - p, p) = held
        end do
        held = side(j)
        side(j) = side(p)
        side(p) = held
      end if
      if (abs(band(0, j)) < least_pivot) band(0, j) = least_pivot
      do r = j + 1, min(j + width, m)
        factor = band(j - r, r)/band(0, j)
        if (factor == 0.0_qp) cycle
        band(j - r:last - r, r) = band(j - r:last - r, r) - factor*band(0:last - j, j)
        side(r) = side(r) - factor*side(j)
      end do
    end do
    do j = m, 1, -1
      last = min(j + 2*width, m)
      side(j) = (side(j) - dot_product(band(1:last - j, j), side(j + 1:last)))/band(0, j)
    end do
  end subroutine solve_band

  pure real(qp) function stiffness_of(stiffness) result(sum_of)
    !! Work of the joints' own forces on their motions, as if all were of one sign.
    type(extended_stiffness), intent(in) :: stiffness      !! with its joints moved
    integer :: j
    sum_of = 0.0_qp
    do j = 1, 2
      sum_of = sum_of + sum(abs(stiffness%own(j, j, :))*stiffness%motion(j, :)**2)
    end do
  end function stiffness_of

  pure function states_of(stiffness, i) result(state)
    !! v, ψ, M and N at the inner and the outer end of piece i, (4, 2).
    type(extended_stiffness), intent(in) :: stiffness      !! with its joints moved
    integer, intent(in) :: i
    real(qp) :: state(4, 2)
    real(qp), dimension(2) :: even, odd, even_force, odd_force
    associate (outer => stiffness%motion(:, i), inner => stiffness%motion(:, i - 1)*[1.0_qp, -1.0_qp])
      even = 0.5_qp*(outer + inner)
      odd = 0.5_qp*(outer - inner)
    end associate
    even_force = times(stiffness%even(:, :, i), even)
    odd_force = times(stiffness%odd(:, :, i), odd)
    state(:, 2) = [even + odd, even_force(2) + odd_force(2), even_force(1) + odd_force(1)]
    state(:, 1) = [even(1) - odd(1), odd(2) - even(2), even_force(2) - odd_force(2), odd_force(1) - even_force(1)]
  end function states_of

  pure function amplitudes_of(stiffness, first, last, outer) result(amplitude)
    !! Amplitudes of the motions of one piece that stands in so many parts.
    type(extended_stiffness), intent(in) :: stiffness      !! with its joints moved
    integer, intent(in) :: first, last                     !! parts
    type(dd), intent(in) :: outer(4, 4)                    !! states of the motions of the whole piece
    real(qp) :: amplitude(4)
    real(qp), dimension(4, 2) :: inside, outside, state
    inside = states_of(stiffness, first)
    outside = states_of(stiffness, last)
    state(:, 1) = 0.5_qp*(outside(:, 2) + inside(:, 1)*[1.0_qp, -1.0_qp, 1.0_qp, -1.0_qp])
    state(:, 2) = outside(:, 2) - state(:, 1)
    amplitude(1:2) = shares(to_quad(outer(:, 1:2)), state(:, 1))
    amplitude(3:4) = shares(to_quad(outer(:, 3:4)), state(:, 2))
  end function amplitudes_of

  pure function shares(f, state) result(share)
    !! Of two motions in a state: from the two of its four numbers that tell them apart best.
    real(qp), intent(in) :: f(4, 2), state(4)
    real(qp) :: share(2)
    real(qp) :: size_of(4), det, best
    integer :: i, j, rows(2)
    size_of = max(abs(f(:, 1)), abs(f(:, 2)), real(tiny(1.0_dp), qp))
    best = -1.0_qp
    do j = 2, 4
      do i = 1, j - 1
        det = abs(f(i, 1)*f(j, 2) - f(i, 2)*f(j, 1))/(size_of(i)*size_of(j))
        if (det <= best) cycle
        best = det
        rows = [i, j]
      end do
    end do
    share = times(inverse(f(rows, :)), state(rows))
  end function shares

end module bw_joint_motion
