module bw_extended_residual
  !! What drives a motion that is no mode: by how much it fails the conditions at the joints, in double-double. Amplitudes and
  !! motions of bodies are taken as they are, and what remains is as good as they are. With it Green's identity (bw_mode_probe)
  !! gives λ to twice the digits of a motion.
  use bw_double_double, only: dd, to_dd, operator(+), operator(-), operator(*)
  use bw_extended_ends, only: extended_ends
  use bw_joint_elimination, only: solve
  use bw_kinds, only: dp
  use bw_mode_probe, only: eliminate_drive, left_vector, mode_probe, piece_system, set_frequency, weigh
  use bw_piece_beam, only: beam_joint, beam_root
  implicit none (type, external)
  private
  public :: find_drive, is_motion, polish, refine

contains

  pure subroutine refine(system, probe, lambda)
    !! λ in double-double of the mode where a probe is.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(inout) :: lambda
    real(dp), parameter :: small = 1.0e-13_dp      ! of λ: the square of such a change is rounding
    type(dd) :: before, change
    before = lambda
    call correct(system, probe, lambda)
    change = lambda - before
    if (abs(change%hi) > small*abs(lambda%hi)) call correct(system, probe, lambda)
    call set_frequency(system, lambda, probe)
  end subroutine refine

  pure subroutine correct(system, probe, lambda)
    !! λ by Green's identity.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(inout) :: lambda
    call set_frequency(system, lambda, probe)
    call find_drive(system, probe)
    call weigh(system, probe)
    lambda = lambda + sum(left_vector(probe)*probe%drive)/probe%mass
  end subroutine correct

  logical function is_motion(system, probe)
    !! A probe's motion meets the conditions at the joints to half of the digits.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(dp), parameter :: little = 1.0e-8_dp
    call find_drive(system, probe)
    is_motion = maxval(abs(probe%drive)) < little*maxval(abs(probe%motion)/probe%unit(1:2, :))
  end function is_motion

  pure subroutine polish(system, probe, lambda)
    !! Take from the motion of a mode what rounding has put into it of others, and λ in double-double: what the motion fails
    !! is what these motions fail.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(inout) :: lambda
    real(dp) :: amplitude(4, size(system%piece)), motion(2, 0:size(system%piece)), lack
    call correct(system, probe, lambda)
    call set_frequency(system, lambda, probe)
    call find_drive(system, probe)
    lack = maxval(abs(probe%drive))
    amplitude = probe%amplitude
    motion = probe%motion
    call eliminate_drive(system, probe)
    call solve(probe%factors, probe%amplitude)
    call weigh(system, probe)
    probe%amplitude = amplitude - probe%amplitude
    probe%motion = motion - probe%motion
    call find_drive(system, probe)
    if (.not. maxval(abs(probe%drive)) < lack) then            ! of the mode itself too much was taken away
      probe%amplitude = amplitude
      probe%motion = motion
      call find_drive(system, probe)
    end if
    call weigh(system, probe)
  end subroutine polish

  pure subroutine find_drive(system, probe)
    !! The drive of a probe's motion at its frequency.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), dimension(4) :: before, after, next
    integer :: i, n
    n = size(system%piece)
    before = dd()
    do i = 0, n
      after = dd()
      if (i < n) call end_states(extended_ends(system%piece(i + 1), probe%frequency), probe%amplitude(:, i + 1), after, next)
      if (i > 0) call drive_joint(system%beam%joint(i), i, before, after, probe)
      if (i == 0) call drive_joint(springs_of(system%beam%root), 0, before, after, probe)
      before = next
    end do
    where ([system%beam%root%holds_deflection, system%beam%root%holds_turning]) probe%drive(2, :, 0) = 0.0_dp
  end subroutine find_drive

  pure type(beam_joint) function springs_of(root) result(joint)
    !! The springs of the root as what a joint has.
    type(beam_root), intent(in) :: root
    joint%stiffness = root%stiffness
    joint%turning_stiffness = root%turning_stiffness
  end function springs_of

  pure subroutine drive_joint(joint, i, before, after, probe)
    type(beam_joint), intent(in) :: joint          !! what joint i has
    integer, intent(in) :: i                       !! 0 is the root
    type(dd), intent(in) :: before(4), after(4)    !! states of the pieces on both sides; no forces beyond root and tip
    type(mode_probe), intent(inout) :: probe
    type(dd) :: load(2), rest(2)
    associate (frequency => probe%frequency, unit => probe%unit(:, i), d => probe%drive(:, :, i), &
               motion => to_dd(probe%motion(:, i)))
      load = [joint%stiffness - joint%mass*frequency%lambda, joint%turning_stiffness - joint%inertia*frequency%beta_squared]
      rest = before(4:3:-1) - after(4:3:-1) + load*motion
      d(2, :) = rest%hi/unit(4:3:-1)
      rest = before(1:2) - motion
      d(1, :) = rest%hi/unit(1:2)
      rest = motion - after(1:2)
      d(3, :) = rest%hi/unit(1:2)
      if (i == size(probe%ends)) d(3, :) = -d(1, :)
      if (i == 0 .or. i == size(probe%ends)) d(1, :) = 0.0_dp
    end associate
  end subroutine drive_joint

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
