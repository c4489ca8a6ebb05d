module bw_extended_residual
  !! Residuals of the conditions at the joints in binary128, for given amplitudes of pieces and motions of bodies,
  !! which are taken as exact. With Green's identity (bw_mode_probe) they give λ to twice the digits of a motion.
  use bw_double_double, only: dd, to_quad, operator(+), operator(-)
  use bw_extended_ends, only: extended_ends
  use bw_kinds, only: dp, qp
  use bw_mode_probe, only: mode_probe, piece_system, set_frequency, find_modal_mass, work_of_drive
  implicit none (type, external)
  private
  public :: find_drive, refine

contains

  pure subroutine refine(system, probe, lambda)
    !! Refine λ of the mode at a probe to double-double.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(inout) :: lambda
    real(dp), parameter :: small = 1.0e-13_dp      ! of λ: the square of such a change is below rounding
    type(dd) :: before, change
    before = lambda
    call correct(system, probe, lambda)
    change = lambda - before
    if (abs(change%hi) > small*abs(lambda%hi)) call correct(system, probe, lambda)
    call set_frequency(system, lambda, probe)
  end subroutine refine

  pure subroutine correct(system, probe, lambda)
    !! Correct λ by Green's identity.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(inout) :: lambda
    call set_frequency(system, lambda, probe)
    call find_drive(system, probe)
    call find_modal_mass(system, probe)
    lambda = lambda + sum(work_of_drive(probe, probe))/probe%mass
  end subroutine correct

  pure subroutine find_drive(system, probe)
    !! Find the drive that corresponds to the residuals of a probe's motion at its frequency.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(qp), dimension(4) :: before, after, next
    integer :: i, n
    n = size(system%piece)
    before = 0.0_qp
    do i = 0, n
      after = 0.0_qp
      if (i < n) call end_states(extended_ends(system%piece(i + 1), probe%frequency), probe%amplitude(:, i + 1), after, next)
      if (i == 0) then
        call drive_root(system, after, probe)
      else
        call drive_joint(system, i, before, after, probe)
      end if
      before = next
    end do
  end subroutine find_drive

  pure subroutine drive_root(system, after, probe)
    type(piece_system), intent(in) :: system
    real(qp), intent(in) :: after(4)
    type(mode_probe), intent(inout) :: probe
    real(qp) :: rest(2)
    probe%drive(:, :, 0) = 0.0_dp
    associate (root => system%beam%root, unit => probe%unit(:, 0), jump => probe%jump(:, 2, 0), motion => probe%motion(:, 0))
      rest = motion - after(1:2)
      probe%drive(3, :, 0) = real(rest, dp)/jump
      rest = motion*to_quad([root%stiffness, root%turning_stiffness]) - after(4:3:-1)
      if (.not. root%holds_deflection) probe%drive(2, 1, 0) = real(rest(1), dp)/unit(4)
      if (.not. root%holds_turning) probe%drive(2, 2, 0) = real(rest(2), dp)/unit(3)
    end associate
  end subroutine drive_root

  pure subroutine drive_joint(system, i, before, after, probe)
    type(piece_system), intent(in) :: system
    integer, intent(in) :: i
    real(qp), intent(in) :: before(4), after(4)
    type(mode_probe), intent(inout) :: probe
    real(qp) :: load(2), rest(2)
    associate (joint => system%beam%joint(i), frequency => probe%frequency, unit => probe%unit(:, i), d => probe%drive(:, :, i), &
               jump => probe%jump(:, :, i), motion => probe%motion(:, i))
      load = to_quad([joint%stiffness, joint%turning_stiffness]) &
        - to_quad([joint%mass, joint%inertia])*to_quad([frequency%lambda, frequency%beta_squared])
      rest = before(1:2) - motion
      if (i < size(system%piece)) then
        d(1, :) = real(rest, dp)/jump(:, 1)
        rest = motion - after(1:2)
        d(3, :) = real(rest, dp)/jump(:, 2)
      else
        d(1, :) = 0.0_dp
        d(3, :) = -real(rest, dp)/jump(:, 2)
      end if
      rest = before(4:3:-1) - after(4:3:-1) + load*motion
      d(2, :) = real(rest, dp)/unit(4:3:-1)
    end associate
  end subroutine drive_joint

  pure subroutine end_states(outer_states, amplitude, inner, outer)
    !! Return the states at both ends of a piece.
    real(qp), intent(in) :: outer_states(4, 4)   !! (state, motion)
    real(dp), intent(in) :: amplitude(4)
    real(qp), intent(out) :: inner(4), outer(4)
    real(qp) :: even(4), odd(4)
    even = matmul(outer_states(:, :2), real(amplitude(:2), qp))
    odd = matmul(outer_states(:, 3:), real(amplitude(3:), qp))
    outer = even + odd
    inner = (even - odd)*[1, -1, 1, -1]
  end subroutine end_states

end module bw_extended_residual
