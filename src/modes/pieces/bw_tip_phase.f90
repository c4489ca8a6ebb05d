module bw_tip_phase
  !! The distance of modes from a frequency, from phases at the tip.
  !!
  !! The beam inwards of the tip admits two motions there, deflections D with forces F. Scaled, and rotated together
  !! with the load of the tip's attachments, they have two directions with F = D tan φ, and φ = 0 at a mode. Both φ
  !! decrease monotonically with frequency: dφ/dβ² = −∫ρAv² + ρIψ² dx − the part of attachments, for a motion with F² +
  !! D² = 1. In a beam with one wave from end to end they are almost linear, and one step finds the mode; a mode that
  !! hardly reaches the tip is not visible there, and the search starts without them.
  use bw_constants, only: pi
  use bw_joint_elimination, only: joint_loads, solve
  use bw_kinds, only: dp
  use bw_mode_probe, only: improve_drive, keep_in_range, mode_probe, piece_system, find_modal_mass
  implicit none (type, external)
  private
  public :: estimate_distance


contains

  pure subroutine estimate_distance(system, probe, more, step)
    !! Estimate the distance of a mode in β² from a frequency set up without drive. Its motion, as far as visible at the
    !! tip, becomes the drive.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    integer, intent(in) :: more                    !! number of the mode less the number of modes below
    real(dp), intent(out) :: step
    real(dp) :: phase(2), share(2, 2), turned(2, 2), fall(2), carried(2)
    integer :: j, n, which
    n = size(probe%ends)
    associate (tip => system%beam%joint(n))
      call tip_phases(probe%factors%state(:, :, n), probe%loads(n), probe%unit(:, n), phase, share, turned)
      carried = [tip%mass%hi, tip%inertia%hi]
      do j = 2, 1, -1                              ! most often the first is nearer
        call move_freely(system, share(:, j), probe)
        fall(j) = probe%mass + sum(carried*(turned(:, j) - probe%motion(:, n)**2))
        fall(j) = max(fall(j), epsilon(1.0_dp)*probe%mass)     ! with an immense body nothing else may remain
      end do
    end associate
    call mode_steps(phase, fall, more, step, which)
    if (which == 2) call move_freely(system, share(:, 2), probe)
    call improve_drive(probe)
  end subroutine estimate_distance

  pure subroutine move_freely(system, share, probe)
    !! Find a motion that satisfies all conditions except those at the tip.
    type(piece_system), intent(in) :: system
    real(dp), intent(in) :: share(2)               !! of the two possible ones
    type(mode_probe), intent(inout) :: probe
    real(dp) :: tip(4)
    integer :: n
    n = size(probe%ends)
    probe%factors%share(:, n) = share
    probe%factors%second(n) = 0.0_dp
    call solve(probe%factors, probe%ends, probe%amplitude)
    tip = matmul(probe%factors%state(:, :, n), share)
    probe%drive(2, :, n) = [(tip(4) + probe%loads(n)%deflection*tip(1))/probe%unit(4, n), &
                            (tip(3) + probe%loads(n)%turning*tip(2))/probe%unit(3, n)]
    call keep_in_range(probe)
    call find_modal_mass(system, probe)
  end subroutine move_freely

  pure subroutine tip_phases(state, load, unit, phase, share, turned)
    !! Find both φ at one frequency, and their motions, scaled to F² + D² = 1.
    real(dp), intent(in) :: state(4, 2)          !! v, ψ, M and N of two motions
    type(joint_loads), intent(in) :: load        !! of the tip's attachments
    real(dp), intent(in) :: unit(4)              !! scales of v, ψ, M and N
    real(dp), intent(out) :: phase(2)            !! φ, from 0 to π
    real(dp), intent(out) :: share(2, 2)         !! of the two motions for each φ, (motion, φ)
    real(dp), intent(out) :: turned(2, 2)        !! decrease of φ per mass and inertia at the tip, (2, φ)
    real(dp) :: plane(4, 2), sine(2, 2), cosine(2, 2), mixed(2, 2), axis(2, 2), size_of, along, angle
    integer :: j
    plane([1, 3], :) = turned_rows(state(1, :), state(4, :), unit(4)/unit(1), load%deflection)
    plane([2, 4], :) = turned_rows(state(2, :), state(3, :), unit(3)/unit(2), load%turning)
    size_of = norm2(plane(:, 1))
    share(:, 1) = [1.0_dp/size_of, 0.0_dp]
    plane(:, 1) = plane(:, 1)/size_of
    along = dot_product(plane(:, 1), plane(:, 2))
    plane(:, 2) = plane(:, 2) - along*plane(:, 1)
    size_of = max(norm2(plane(:, 2)), tiny(size_of))
    share(:, 2) = [-along*share(1, 1), 1.0_dp]/size_of
    plane(:, 2) = plane(:, 2)/size_of
    cosine = matmul(transpose(plane(1:2, :)), plane(1:2, :)) - matmul(transpose(plane(3:4, :)), plane(3:4, :))
    sine = matmul(transpose(plane(1:2, :)), plane(3:4, :))
    sine = sine + transpose(sine)
    mixed = 0.6_dp*cosine + 0.8_dp*sine          ! both have the same axes, and so has any combination
    angle = 0.5_dp*atan2(2.0_dp*mixed(1, 2), mixed(1, 1) - mixed(2, 2))
    axis = reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [2, 2])
    do j = 1, 2
      phase(j) = modulo(0.5_dp*atan2(dot_product(axis(:, j), matmul(sine, axis(:, j))), &
                                     dot_product(axis(:, j), matmul(cosine, axis(:, j)))), pi)
    end do
    share = matmul(share, axis)
    plane = matmul(plane, axis)
    turned(1, :) = (plane(1, :)**2 + plane(3, :)**2)*(unit(1)/unit(4))/(1.0_dp + (load%deflection*unit(1)/unit(4))**2)
    turned(2, :) = (plane(2, :)**2 + plane(4, :)**2)*(unit(2)/unit(3))/(1.0_dp + (load%turning*unit(2)/unit(3))**2)
  end subroutine tip_phases

  pure function turned_rows(motion, force, stiffness, load) result(rows)
    !! Return D and F of one direction, rotated so that F = 0 where the force equals that of the load.
    real(dp), intent(in) :: motion(2), force(2)
    real(dp), intent(in) :: stiffness            !! scale of force over scale of motion
    real(dp), intent(in) :: load
    real(dp) :: rows(2, 2)
    real(dp) :: d(2), f(2), c, s
    d = motion*sqrt(stiffness)
    f = force/sqrt(stiffness)
    c = 1.0_dp/hypot(1.0_dp, load/stiffness)
    s = (load/stiffness)*c
    rows(1, :) = c*d - s*f
    rows(2, :) = c*f + s*d
  end function turned_rows

  pure subroutine mode_steps(phase, fall, more, step, which)
    !! Estimate the distance of a mode in β², and which phase is 0 there.
    real(dp), intent(in) :: phase(2)
    real(dp), intent(in) :: fall(2)              !! −dφ/dβ²
    integer, intent(in) :: more                  !! number of the mode less the number of modes below
    real(dp), intent(out) :: step
    integer, intent(out) :: which
    real(dp) :: way(2)
    integer :: i
    way = merge(phase, pi - phase, more > 0)
    do i = 1, merge(more, 1 - more, more > 0)
      which = minloc(way/fall, dim=1)
      step = way(which)/fall(which)
      way(which) = way(which) + pi
    end do
    if (more <= 0) step = -step
  end subroutine mode_steps

end module bw_tip_phase
