module bw_contact_flexibility
  !! What modes that are not summed give way by where a mass is pressed against a beam, and what that moves elsewhere.
  use bw_case_result, only: case_motion
  use bw_change_of_bodies, only: body_type
  use bw_kinds, only: dp
  use bw_lasting_contact, only: lasting_contacts
  use bw_mode_set, only: deflections, turns
  use bw_piece_beam, only: arm_of
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: pieces_of, struck_beam, varying_of
  use bw_static_shape, only: find_motion_residual, find_residual
  use bw_timeline, only: carried_type
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: flexibility_of, show_residual

  type, public :: flexibility_type
    !! What modes that are not summed give way by under a force of 1 at the place that the mass strikes.
    real(dp) :: here = 0.0_dp                        !! that place
    real(dp), allocatable :: seen(:, :)              !! as that of load_type, (points, 3)
    real(dp), allocatable :: at_bodies(:, :)         !! deflection and turning, (bodies, 2)
    real(dp), allocatable :: of_loads(:, :, :)       !! the same under loads of 1, (bodies, 2, loads)
  end type flexibility_type

contains

  function flexibility_of(scene, motion, configuration, carried, summed, bodies) result(flexibility)
    !! Of the modes of a configuration beyond those that are summed.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: configuration
    type(carried_type), intent(in) :: carried
    integer, intent(in) :: summed
    type(body_type), intent(in) :: bodies(:)
    type(flexibility_type) :: flexibility
    type(struck_beam) :: pieces
    type(varying_beam) :: given
    real(dp) :: here(1, 3)
    pieces = pieces_of(scene, motion%units, .false., carried%body)
    given = varying_of(scene, motion%units, pieces)
    associate (set => motion%modes%configuration(configuration)%set, points => scene%response%points)
      allocate (flexibility%seen(size(points), 3))
      call find_residual(given, pieces%struck, set, summed, [scene%impact%position], here)
      call find_residual(given, pieces%struck, set, summed, points, flexibility%seen)
      flexibility%here = max(0.0_dp, here(1, deflections) + arm_of(given%beam, scene%impact%position)*here(1, turns))
      flexibility%at_bodies = find_motion_residual(given, pieces%struck, set, summed, bodies%position)
    end associate
  end function flexibility_of

  pure subroutine show_residual(flexibility, contacts)
    !! Of the segments that have none yet.
    type(flexibility_type), intent(in) :: flexibility
    type(lasting_contacts), intent(inout) :: contacts
    integer :: i
    do i = size(contacts%segments), 1, -1
      if (.not. allocated(contacts%segments(i)%load)) cycle
      if (allocated(contacts%segments(i)%load%residual)) return
      contacts%segments(i)%load%residual = flexibility%seen
    end do
  end subroutine show_residual

end module bw_contact_flexibility
