module bw_some_modes
  !! A few modes of the beam alone, for studies of many beams that need only frequencies, damping and shapes. Under
  !! tension a small basis suffices for the frequencies, and waves are left out.
  use bw_beam_motion, only: case_modes
  use bw_beam_units, only: beam_units
  use bw_case_modes, only: find_sources
  use bw_damping, only: law_of
  use bw_mode_demand, only: mode_demand
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_piece_set, only: piece_set
  use bw_piece_source, only: set_of_pieces
  use bw_scene, only: by_pieces, scene_type, varies_along_pieces
  use bw_scene_pieces, only: pieces_of, struck_beam, varying_of
  use bw_segment, only: alone
  use bw_strain_modes, only: strain_modes
  use bw_strain_set, only: strain_set
  implicit none (type, external)
  private
  public :: find_some_modes

  integer, parameter :: digits = 6               !! of shapes; frequencies have twice as many

contains

  subroutine find_some_modes(scene, units, number, set, place, monitor)
    !! Find modes by their numbers.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: number(:)             !! ascending; may be empty
    class(mode_set), allocatable, intent(out) :: set   !! unallocated or not `resolved` on failure
    integer, intent(out) :: place(:)             !! index of each in the set, which may hold others, (number)
    class(monitor_type), intent(inout) :: monitor      !! the modes are invalid if it requests a stop
    type(case_modes) :: known
    integer :: i
    place = number
    if (varies_along_pieces(scene)) then
      call find_varying(scene, units, max(1, maxval(number)), set, monitor)
      return
    end if
    place = [(i, i=1, size(number))]
    if (by_pieces(scene)) then
      call find_of_pieces(scene, units, number, set, monitor)
    else
      call find_sources(scene, units, monitor, known)
      if (known%resolved) call known%configuration(alone)%source%find(number, set)
    end if
  end subroutine find_some_modes

  subroutine find_of_pieces(scene, units, number, set, monitor)
    !! Find modes of a beam of pieces without tension, and no critical speed.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: set
    class(monitor_type), intent(inout) :: monitor
    type(piece_set), allocatable :: found
    type(struck_beam) :: pieces
    allocate (found)
    pieces = pieces_of(scene, units, .false.)
    call set_of_pieces(pieces%beam, number, set=found, struck=pieces%struck, monitor=monitor)
    found%struck_at = pieces%position
    call move_alloc(found, set)
    if (set%resolved .and. allocated(scene%damping)) call set%damp(law_of(scene%damping, units))
  end subroutine find_of_pieces

  subroutine find_varying(scene, units, count, set, monitor)
    !! Find the first modes of a beam with tension or taper.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: count                 !! ≥ 1
    class(mode_set), allocatable, intent(out) :: set
    class(monitor_type), intent(inout) :: monitor
    type(strain_set), allocatable :: found
    type(struck_beam) :: pieces
    allocate (found)
    pieces = pieces_of(scene, units, .false.)
    call strain_modes(varying_of(scene, units, pieces), count, pieces%struck, found, monitor, &
                      mode_demand(digits, waves=.false.))
    found%struck_at = pieces%position
    call move_alloc(found, set)
    if (set%resolved .and. allocated(scene%damping)) call set%damp(law_of(scene%damping, units))
  end subroutine find_varying

end module bw_some_modes
