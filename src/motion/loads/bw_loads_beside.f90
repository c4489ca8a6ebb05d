module bw_loads_beside
  !! Loads in terms of the beam's modes and of a mass beside it, for any configuration of the beam in lasting contacts.
  use bw_acting_loads, only: acting_loads
  use bw_beam_motion, only: beam_motion
  use bw_kinds, only: dp
  use bw_load_course, only: scaled_course
  use bw_load_modes, only: find_residuals
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: arm_of
  use bw_placed_loads, only: find_drive, placed_loads, residual_at
  use bw_scene, only: scene_type, unit_velocity
  use bw_static_shape, only: deflection, hub_turn
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: project_loads, modes_taking_part, unit_force

contains

  pure real(dp) function unit_force(scene, motion) result(newton)
    !! Return the unit of force of bw_segment, N.
    type(scene_type), intent(in) :: scene
    class(beam_motion), intent(in) :: motion
    newton = motion%units%mass*unit_velocity(scene)/motion%units%time%hi
  end function unit_force

  pure integer function modes_taking_part(motion, configuration, summed) result(count)
    !! Return how many modes of a configuration take part: the same fraction as of the first.
    class(beam_motion), intent(in) :: motion
    integer, intent(in) :: configuration
    integer, intent(in) :: summed                    !! modes of the first
    associate (all => motion%modes%configuration)
      count = (summed*all(configuration)%set%count + all(1)%set%count - 1)/all(1)%set%count
    end associate
  end function modes_taking_part

  subroutine project_loads(scene, motion, configuration, given, summed, loads, monitor, acting, places, at_places)
    !! Express loads in terms of the beam's modes and of the mass beside it.
    type(scene_type), intent(in) :: scene
    class(beam_motion), intent(in) :: motion
    integer, intent(in) :: configuration
    type(varying_beam), intent(in) :: given          !! with the bodies that it carries
    integer, intent(in) :: summed                    !! modes that take part
    type(placed_loads), intent(in) :: loads          !! N
    class(monitor_type), intent(inout) :: monitor    !! results are invalid if it requests a stop
    type(acting_loads), allocatable, intent(out) :: acting
    real(dp), intent(in), optional :: places(:)      !! ξ
    real(dp), allocatable, intent(out), optional :: at_places(:, :, :)
      !! quasi-static deflection and rotation there by omitted modes, under a load of 1, (places, 2, loads)
    real(dp), allocatable :: drive(:, :), nothing(:, :), ignored(:), residual(:, :, :), terms(:, :, :), weights(:, :, :)
    real(dp) :: no_points(0)
    integer :: l, p
    allocate (acting)
    associate (set => motion%modes%configuration(configuration)%set, place => scene%impact%position)
      allocate (nothing(set%count, 0), ignored(1 + size(loads%place)), acting%residual(size(loads%course)), &
                acting%drive(set%count + 1, size(loads%course)))
      call find_drive(given, set, loads%place, loads%accelerated, monitor, drive, no_points, nothing)
      if (monitor%stop_requested()) return
      allocate (residual(size(drive, 2), 1, hub_turn), terms(size(drive, 2), 1, hub_turn))
      allocate (weights(set%count, 1, hub_turn), source=0.0_dp)
      weights(:, :, deflection) = set%some_shapes(1, set%count, [place])
      weights(:, 1, hub_turn) = set%hub_turns()
      call find_residuals(given, set, summed, loads%place, loads%accelerated, drive, weights, [place], residual, terms, &
                          ignored)
      acting%course = scaled_course(loads%course, 1.0_dp/unit_force(scene, motion))
      do l = 1, size(loads%course)
        associate (kind => loads%kind(l))
          acting%drive(:set%count, l) = drive(:, kind)/set%modal_mass
          acting%drive(set%count + 1, l) = merge(1.0_dp, 0.0_dp, kind > size(loads%place))   ! the frame accelerates the mass
          acting%residual(l) = residual(kind, 1, deflection) + arm_of(given%beam, place)*residual(kind, 1, hub_turn)
        end associate
      end do
      if (.not. present(at_places)) return
      allocate (at_places(size(places), 2, size(loads%course)))
      do p = 1, size(places)
        at_places(p, :, :) = residual_at(given, set, summed, loads, drive, places(p))
      end do
    end associate
  end subroutine project_loads

end module bw_loads_beside
