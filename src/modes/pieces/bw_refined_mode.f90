module bw_refined_mode
  !! Modes to twice the digits, by iterative refinement.
  !!
  !! What a motion fails at the joints is found in double-double. Weighed as in bw_mode_probe it is the error of the
  !! frequency, but for the square of that of the amplitudes; as a right side it gives the error of the amplitudes.
  use bw_double_double, only: dd, operator(+), operator(-), operator(*)
  use bw_extended_ends, only: extended_ends
  use bw_joint_elimination, only: eliminate, solve
  use bw_kinds, only: dp
  use bw_mode_probe, only: mask_ends, mode_probe, piece_system, probe_at, weigh
  implicit none (type, external)
  private
  public :: refine

contains

  pure subroutine refine(system, probe, lambda)
    !! The frequency in double-double of the mode where a probe is, and amplitudes as good as rounded ones.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(out) :: lambda
    call refine_frequency(system, probe, lambda)
    call refine_motion(system, lambda, probe)
    call refine_frequency(system, probe, lambda)   ! its error is the square of that of the amplitudes
  end subroutine refine

  pure subroutine refine_frequency(system, probe, lambda)
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(out) :: lambda
    real(dp), dimension(4, 0:size(probe%ends)) :: left, residual
    call find_residual(system, probe, residual)
    call weigh(system, probe, left)
    lambda = probe%frequency%lambda + sum(left*residual)/probe%mass
  end subroutine refine_frequency

  pure subroutine refine_motion(system, lambda, probe)
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda                 !! in double-double
    type(mode_probe), intent(inout) :: probe       !! where the motion was found
    real(dp), dimension(4, 0:size(probe%ends)) :: left, residual, right
    real(dp) :: motion(4, size(probe%ends))
    integer :: place(2)
    call probe_at(system, lambda, probe)
    motion = probe%amplitude
    call find_residual(system, probe, residual)
    call weigh(system, probe, left)
    right = probe%unit*probe%drive                 ! what the frequency lacks is no error of the motion
    residual = residual - sum(left*residual)/sum(left*right)*right
    call eliminate(system%beam%root, probe%loads, probe%ends, residual, probe%factors)
    call solve(probe%factors, probe%amplitude)
    place = maxloc(abs(motion))                    ! what changes the size of the whole motion is left out
    associate (error => probe%amplitude, part => probe%amplitude(place(1), place(2))/motion(place(1), place(2)))
      probe%amplitude = motion - (error - part*motion)
    end associate
    call weigh(system, probe, left)
  end subroutine refine_motion

  pure subroutine find_residual(system, probe, residual)
    !! What deflection, turning, moment and shear force before each joint exceed those after it by, with what is attached.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(in) :: probe
    real(dp), intent(out) :: residual(4, 0:size(probe%ends))
    type(dd) :: outer(4, 4), before(4), after(4), lack(4)
    integer :: i, n
    n = size(probe%ends)
    do i = 0, n
      after = dd()
      if (i < n) then
        outer = extended_ends(system%piece(i + 1), probe%frequency)
        after = state_of(outer, probe%amplitude(:, i + 1), -1.0_dp)
      end if
      if (i == 0) then
        lack(1:2) = -after(1:2)
        lack(3) = system%beam%root%turning_stiffness*after(2) - after(3)
        lack(4) = system%beam%root%stiffness*after(1) - after(4)
      else
        associate (joint => system%beam%joint(i))
          lack = before - after
          lack(3) = lack(3) + (joint%turning_stiffness - joint%inertia*probe%frequency%beta_squared)*before(2)
          lack(4) = lack(4) + (joint%stiffness - joint%mass*probe%frequency%lambda)*before(1)
        end associate
      end if
      residual(:, i) = lack%hi
      if (i < n) before = state_of(outer, probe%amplitude(:, i + 1), 1.0_dp)
    end do
    call mask_ends(system%beam, residual)
  end subroutine find_residual

  pure function state_of(outer, amplitude, side) result(state)
    !! The state at an end: even motions have even v and M and odd ψ and N, odd ones the other way round.
    type(dd), intent(in) :: outer(4, 4)
    real(dp), intent(in) :: amplitude(4)
    real(dp), intent(in) :: side                   !! 1 at the outer end, −1 at the inner
    type(dd) :: state(4)
    type(dd) :: even, odd
    integer :: q
    do q = 1, 4
      even = outer(q, 1)*amplitude(1) + outer(q, 2)*amplitude(2)
      odd = outer(q, 3)*amplitude(3) + outer(q, 4)*amplitude(4)
      if (mod(q, 2) == 1) then
        state(q) = even + odd*side
      else
        state(q) = odd + even*side
      end if
    end do
  end function state_of

end module bw_refined_mode
