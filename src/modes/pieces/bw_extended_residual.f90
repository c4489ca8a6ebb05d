module bw_extended_residual
  !! By how much a motion fails the conditions at the joints, in double-double: the amplitudes are taken as they are, and
  !! what remains is as good as they are. With it Green's identity (bw_mode_probe) gives λ to twice the digits of a motion.
  use bw_double_double, only: dd, operator(+), operator(-), operator(*)
  use bw_extended_ends, only: extended_ends
  use bw_kinds, only: dp
  use bw_mode_probe, only: mode_probe, piece_system
  implicit none (type, external)
  private
  public :: extended_lacks

contains

  pure function extended_lacks(system, probe) result(lack)
    !! Of v, ψ, M and N at each joint, with a probe's amplitudes at its frequency, (4, 0:n).
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(in) :: probe
    real(dp) :: lack(4, 0:size(system%piece))
    type(dd), dimension(4) :: before, after, next
    type(dd) :: rest(4)
    integer :: i, n
    n = size(system%piece)
    lack = 0.0_dp
    before = dd()
    do i = 0, n
      after = dd()
      if (i < n) call end_states(extended_ends(system%piece(i + 1), probe%frequency), probe%amplitude(:, i + 1), after, next)
      rest = before - after
      call add_loads(system, probe, i, merge(before(1:2), after(1:2), i == n), rest)
      lack(:, i) = rest%hi
      before = next
    end do
    associate (root => system%beam%root)
      lack(merge(4, 1, root%holds_deflection), 0) = 0.0_dp
      lack(merge(3, 2, root%holds_turning), 0) = 0.0_dp
      lack(1:2, n) = 0.0_dp
    end associate
  end function extended_lacks

  pure subroutine add_loads(system, probe, i, motion, rest)
    !! Forces of what is attached to joint i.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(in) :: probe
    integer, intent(in) :: i
    type(dd), intent(in) :: motion(2)            !! v and ψ
    type(dd), intent(inout) :: rest(4)
    if (i == 0) then
      rest(3) = rest(3) + motion(2)*system%beam%root%turning_stiffness
      rest(4) = rest(4) + motion(1)*system%beam%root%stiffness
    else
      associate (joint => system%beam%joint(i), frequency => probe%frequency)
        rest(3) = rest(3) + motion(2)*(joint%turning_stiffness - joint%inertia*frequency%beta_squared)
        rest(4) = rest(4) + motion(1)*(joint%stiffness - joint%mass*frequency%lambda)
      end associate
    end if
  end subroutine add_loads

  pure subroutine end_states(outer_states, amplitude, inner, outer)
    !! The states at both ends of a piece.
    type(dd), intent(in) :: outer_states(4, 4)   !! (state, motion)
    real(dp), intent(in) :: amplitude(4)
    type(dd), intent(out) :: inner(4), outer(4)
    type(dd) :: even, odd
    integer :: q
    do q = 1, 4
      even = outer_states(q, 1)*amplitude(1) + outer_states(q, 2)*amplitude(2)
      odd = outer_states(q, 3)*amplitude(3) + outer_states(q, 4)*amplitude(4)
      outer(q) = even + odd
      inner(q) = even - odd
      if (mod(q, 2) == 0) inner(q) = odd - even
    end do
  end subroutine end_states

end module bw_extended_residual
