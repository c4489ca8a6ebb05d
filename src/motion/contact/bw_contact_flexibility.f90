module bw_contact_flexibility
  !! The residual flexibility of omitted modes under the force of a mass pressed against the beam.
  use bw_beam_motion, only: beam_motion
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
  public :: flexibility_of, store_residual

  type, public :: flexibility_type
    !! Residual flexibility under a force of 1 at the struck place.
    real(dp) :: here = 0.0_dp                        !! of that place
    real(dp), allocatable :: seen(:, :)              !! see load_type, (points, 3)
    real(dp), allocatable :: at_bodies(:, :)         !! deflection and rotation, (bodies, 2)
    real(dp), allocatable :: of_loads(:, :, :)       !! the same under loads of 1, (bodies, 2, loads)
  end type flexibility_type

contains

  function flexibility_of(scene, motion, configuration, carried, summed, bodies) result(flexibility)
    !! Return the residual flexibility of the modes of a configuration that are not summed.
    type(scene_type), intent(in) :: scene
    class(beam_motion), intent(in) :: motion
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

  pure subroutine store_residual(flexibility, contacts)
    !! Set it in those segments with contact that have none yet.
    type(flexibility_type), intent(in) :: flexibility
    type(lasting_contacts), intent(inout) :: contacts
    integer :: i
    do i = size(contacts%segments), 1, -1
      if (.not. allocated(contacts%segments(i)%load)) cycle
      if (allocated(contacts%segments(i)%load%residual)) return
      contacts%segments(i)%load%residual = flexibility%seen
    end do
  end subroutine store_residual

end module bw_contact_flexibility
