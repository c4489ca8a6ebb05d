module bw_placed_loads
  !! The loads of a scene at their places, and how they drive the modes of a configuration.
  use bw_kinds, only: dp
  use bw_load_course, only: load_course
  use bw_load_modes, only: find_residuals, find_shears
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: arm_of
  use bw_scene, only: scene_type
  use bw_static_shape, only: columns, deflection, hub_turn, turning
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: find_drive, place_loads, residual_at

  type, public :: placed_loads
    !! Loads and their places.
    type(load_course), allocatable :: course(:)
    real(dp), allocatable :: place(:)                !! ξ of forces; each is one kind of load
    logical :: accelerated = .false.                 !! the last kind is the acceleration of the frame
    integer, allocatable :: kind(:)                  !! of each course
  end type placed_loads

contains

  pure subroutine place_loads(scene, loads)
    !! Place the loads: each force is a kind of its own, all base motions are one.
    type(scene_type), intent(in) :: scene
    type(placed_loads), intent(inout) :: loads     !! with the courses
    integer :: l
    allocate (loads%place(0))
    if (allocated(scene%forces)) loads%place = scene%forces%position
    loads%accelerated = allocated(scene%bases)
    loads%kind = [(min(l, size(loads%place) + 1), l=1, size(loads%course))]
  end subroutine place_loads

  subroutine find_drive(given, modes, places, accelerated, monitor, drive, points, shear)
    !! Find the modal loads of each kind: forces at their places, then an acceleration of −1 of the frame.
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: places(:)                    !! of forces
    logical, intent(in) :: accelerated                   !! the frame is accelerated
    class(monitor_type), intent(inout) :: monitor        !! results are invalid if it requests a stop
    real(dp), allocatable, intent(out) :: drive(:, :)    !! (modes, kinds)
    real(dp), intent(in) :: points(:)                    !! empty: no shear forces
    real(dp), intent(out) :: shear(:, :)                 !! shear forces of the modes at the points, (modes, points)
    real(dp) :: participation(modes%count), motion(modes%count, 2)
    integer :: i
    if (accelerated .or. size(points) > 0) call find_shears(given, modes, points, shear, participation, monitor)
    allocate (drive(modes%count, size(places) + merge(1, 0, accelerated)))
    do i = 1, size(places)
      motion = modes%motion_at(places(i))
      drive(:, i) = motion(:, 1)
    end do
    if (accelerated) drive(:, size(places) + 1) = participation
  end subroutine find_drive

  function residual_at(given, modes, summed, acting, drive, place) result(residual)
    !! Return the quasi-static displacement and rotation of a place by omitted modes under each load, (2, loads).
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed
    type(placed_loads), intent(in) :: acting
    real(dp), intent(in) :: drive(:, :)            !! that of `find_drive`
    real(dp), intent(in) :: place                  !! ξ
    real(dp) :: residual(2, size(acting%course))
    integer, parameter :: few = 64                 ! from here on a static solution is faster than beyond all modes
    real(dp), dimension(size(drive, 2), 1, columns) :: beyond, terms
    real(dp) :: arm, flexibility(1 + size(acting%place)), motion(modes%count, 2), weights(modes%count, 1, columns)
    real(dp), allocatable :: soft(:)
    integer :: l, n
    n = min(few, summed)
    weights = 0.0_dp
    arm = arm_of(given%beam, place)
    motion = modes%motion_at(place)
    weights(:, 1, turning) = motion(:, 2)
    weights(:, 1, hub_turn) = modes%hub_turns()
    weights(:, 1, deflection) = motion(:, 1) - arm*weights(:, 1, hub_turn)
    call find_residuals(given, modes, n, acting%place, acting%accelerated, drive, weights, [place], beyond, terms, &
                        flexibility)
    beyond(:, 1, deflection) = beyond(:, 1, deflection) + arm*beyond(:, 1, hub_turn)
    residual = transpose(beyond(acting%kind, 1, [deflection, turning]))
    soft = 1.0_dp/(modes%modal_mass(n + 1:summed)*modes%beta_squared(n + 1:summed)%hi)
    do l = 1, size(acting%course)                  ! less modes `few` + 1 to `summed`
      residual(:, l) = residual(:, l) - matmul(soft*drive(n + 1:summed, acting%kind(l)), motion(n + 1:summed, :))
    end do
  end function residual_at

end module bw_placed_loads
