module bw_extended_mode
  !! Modes to twice the digits: the inverse iteration of bw_mode_probe with its conditions set up and eliminated in
  !! double-double. Phases then last for long histories, and modes whose frequencies nearly agree are told apart as if they
  !! were far from each other.
  use bw_double_double, only: dd, to_dd, operator(+), operator(-), operator(*), operator(/)
  use bw_extended_ends, only: extended_ends
  use bw_kinds, only: dp
  use bw_mode_probe, only: correction_for, driven, improve_drive, mode_probe, piece_system, set_frequency, weigh
  use bw_piece_beam, only: beam_joint, beam_root
  use bw_piece_waves, only: piece_frequency
  implicit none (type, external)
  private
  public :: extended_motion, refine

  integer, parameter :: rounds = 12
  real(dp), parameter :: settled = 1.0e-24_dp
    !! correction over λ of a round that another one could not better: errors shrink to their squares and below
  real(dp), parameter :: least_pivot = 1.0e-33_dp

contains

  pure subroutine refine(system, probe, lambda)
    !! λ in double-double, and amplitudes as good as rounded ones, of the mode where a probe is.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(inout) :: lambda              !! as the search gave it
    real(dp) :: correction
    integer :: i
    do i = 1, rounds
      call extended_motion(system, lambda, probe)
      correction = correction_for(system%beam, probe, driven(system%beam, probe))
      lambda = lambda + correction
      call improve_drive(probe)
      if (abs(correction) < settled*abs(lambda%hi)) exit
    end do
  end subroutine refine

  pure subroutine extended_motion(system, lambda, probe)
    !! The motion that a drive gives at a frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda
    type(mode_probe), intent(inout) :: probe
    call set_frequency(system, lambda, probe)
    call solve_extended(system, probe%frequency, driven(system%beam, probe), probe%amplitude)
    call weigh(system, probe)
  end subroutine extended_motion

  pure subroutine solve_extended(system, frequency, lack, amplitude)
    !! Amplitudes that fail the conditions by so much.
    type(piece_system), intent(in) :: system
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(in) :: lack(:, 0:)            !! of v, ψ, M and N at each joint, (4, 0:n)
    real(dp), intent(out) :: amplitude(:, :)       !! (4, n)
    type(dd) :: upper(9, 4, size(amplitude, 2)), row(9, 6), outer(4, 4), inner(4, 4)
    integer :: i, n
    n = size(amplitude, 2)
    outer = extended_ends(system%piece(1), frequency)
    row = dd()
    call set_root(system%beam%root, at_inner_end(outer), lack(:, 0), row)
    do i = 1, n
      call part(row)
      if (i < n) then
        call set_before(outer, lack(:, i), row)
        outer = extended_ends(system%piece(i + 1), frequency)
        inner = at_inner_end(outer)
        call set_after(system%beam%joint(i), frequency, inner, row)
      else
        call set_tip(system%beam%joint(n), frequency, outer, lack(:, n), row)
      end if
      call eliminate_piece(merge(6, 4, i < n), row)
      upper(:, :, i) = row(:, 1:4)
      row(1:4, 1:2) = row(5:8, 5:6)
      row(5:8, 1:2) = dd()
      row(9, 1:2) = row(9, 5:6)
    end do
    call substitute(upper, amplitude)
  end subroutine solve_extended

  pure function at_inner_end(outer) result(inner)
    type(dd), intent(in) :: outer(4, 4)            !! states of two even and two odd motions at the outer end
    type(dd) :: inner(4, 4)
    integer :: q
    do q = 1, 4
      inner(q, 1:2) = outer(q, 1:2)*merge(1.0_dp, -1.0_dp, mod(q, 2) == 1)
      inner(q, 3:4) = outer(q, 3:4)*merge(-1.0_dp, 1.0_dp, mod(q, 2) == 1)
    end do
  end function at_inner_end

  pure subroutine set_root(root, inner, lack, row)
    type(beam_root), intent(in) :: root
    type(dd), intent(in) :: inner(4, 4)
    real(dp), intent(in) :: lack(4)
    type(dd), intent(inout) :: row(9, 6)
    if (root%holds_deflection) then
      row(1:4, 1) = inner(1, :)*(-1.0_dp)
      row(9, 1) = to_dd(lack(1))
    else
      row(1:4, 1) = inner(1, :)*root%stiffness - inner(4, :)
      row(9, 1) = to_dd(lack(4))
    end if
    if (root%holds_turning) then
      row(1:4, 2) = inner(2, :)*(-1.0_dp)
      row(9, 2) = to_dd(lack(2))
    else
      row(1:4, 2) = inner(2, :)*root%turning_stiffness - inner(3, :)
      row(9, 2) = to_dd(lack(3))
    end if
  end subroutine set_root

  pure subroutine set_before(outer, lack, row)
    !! Rows 3 … 6: states of the piece before a joint.
    type(dd), intent(in) :: outer(4, 4)
    real(dp), intent(in) :: lack(4)
    type(dd), intent(inout) :: row(9, 6)
    integer :: q
    do q = 1, 4
      row(1:4, q + 2) = outer(q, :)
      row(9, q + 2) = to_dd(lack(q))
    end do
  end subroutine set_before

  pure subroutine set_after(joint, frequency, inner, row)
    !! Less those of the piece after it, with which what is attached moves.
    type(beam_joint), intent(in) :: joint
    type(piece_frequency), intent(in) :: frequency
    type(dd), intent(in) :: inner(4, 4)
    type(dd), intent(inout) :: row(9, 6)
    integer :: q
    do q = 1, 4
      row(5:8, q + 2) = inner(q, :)*(-1.0_dp)
    end do
    row(5:8, 5) = row(5:8, 5) + inner(2, :)*(joint%turning_stiffness - joint%inertia*frequency%beta_squared)
    row(5:8, 6) = row(5:8, 6) + inner(1, :)*(joint%stiffness - joint%mass*frequency%lambda)
    do q = 3, 6
      call divide_row(row(:, q))
    end do
  end subroutine set_after

  pure subroutine set_tip(joint, frequency, outer, lack, row)
    type(beam_joint), intent(in) :: joint
    type(piece_frequency), intent(in) :: frequency
    type(dd), intent(in) :: outer(4, 4)
    real(dp), intent(in) :: lack(4)
    type(dd), intent(inout) :: row(9, 6)
    row(:, 3:4) = dd()
    row(1:4, 3) = outer(3, :) + outer(2, :)*(joint%turning_stiffness - joint%inertia*frequency%beta_squared)
    row(1:4, 4) = outer(4, :) + outer(1, :)*(joint%stiffness - joint%mass*frequency%lambda)
    row(9, 3) = to_dd(lack(3))
    row(9, 4) = to_dd(lack(4))
    call divide_row(row(:, 3))
    call divide_row(row(:, 4))
  end subroutine set_tip

  pure subroutine divide_row(row)
    !! By about its largest element: a power of 2, so that nothing is rounded.
    type(dd), intent(inout) :: row(9)
    row = row*2.0_dp**(-exponent(maxval(abs(row(1:8)%hi))))
  end subroutine divide_row

  pure subroutine part(row)
    !! As in bw_joint_elimination.
    type(dd), intent(inout) :: row(9, 6)
    integer :: c
    call divide_row(row(:, 1))
    call divide_row(row(:, 2))
    c = maxloc(abs(row(1:4, 1)%hi), dim=1)
    row(:, 2) = row(:, 2) - row(:, 1)*(row(c, 2)/row(c, 1))
    row(c, 2) = dd()
    c = mod(c, 4) + 1
    if (maxval(abs(row(1:4, 2)%hi)) < least_pivot) row(c, 2) = to_dd(least_pivot)
    call divide_row(row(:, 2))
  end subroutine part

  pure subroutine eliminate_piece(m, row)
    !! As in bw_joint_elimination.
    integer, intent(in) :: m
    type(dd), intent(inout) :: row(9, 6)
    type(dd) :: pivot(9)
    integer :: c, j, place
    do c = 1, 4
      place = c - 1 + maxloc(abs(row(c, c:m)%hi), dim=1)
      pivot = row(:, place)
      if (abs(pivot(c)%hi) < least_pivot) pivot(c) = to_dd(least_pivot)
      row(:, place) = row(:, c)
      row(:, c) = pivot
      do j = c + 1, m
        row(:, j) = row(:, j) - pivot*(row(c, j)/pivot(c))
      end do
    end do
  end subroutine eliminate_piece

  pure subroutine substitute(upper, amplitude)
    !! From the tip back to the root.
    type(dd), intent(in) :: upper(:, :, :)         !! (9, 4, n)
    real(dp), intent(out) :: amplitude(:, :)
    type(dd) :: x(8), rest
    integer :: c, i, j
    x = dd()
    do i = size(amplitude, 2), 1, -1
      do c = 4, 1, -1
        rest = upper(9, c, i)
        do j = c + 1, 8
          rest = rest - upper(j, c, i)*x(j)
        end do
        x(c) = rest/upper(c, c, i)
      end do
      amplitude(:, i) = x(1:4)%hi
      x(5:8) = x(1:4)
    end do
  end subroutine substitute

end module bw_extended_mode
