module bw_scene_states
  !! The states of a beam from scenes and their lines. The unknowns are those of the first scene; a number of another scene is
  !! the same unknown where the scene gives a value to its name.
  use bw_beam_state, only: beam_state, measured_lines, state_of
  use bw_identify_par, only: identify_par
  use bw_input_values, only: positions_of
  use bw_scene, only: scene_type
  use bw_scene_messages, only: message_list
  use bw_scene_unknowns, only: find_unknown
  implicit none (type, external)
  private
  public :: states_of, unknowns_in

  type, public :: measured_scene
    !! A scene with what was measured in its state.
    type(scene_type) :: scene                    !! without sweeps
    type(measured_lines) :: lines
  end type measured_scene

contains

  subroutine states_of(measured, states)
    !! One state for each scene.
    type(measured_scene), intent(in) :: measured(:)      !! the first has the `&identify` groups
    type(beam_state), allocatable, intent(out) :: states(:)
    integer :: i
    allocate (states(size(measured)))
    do i = 1, size(measured)
      states(i) = state_of(measured(i)%scene, unknowns_in(measured(1)%scene, measured(i)%scene), measured(i)%lines)
    end do
  end subroutine states_of

  function unknowns_in(first, scene) result(unknowns)
    !! The unknowns of the first scene as they stand in another; of group 0 where it does not have them.
    type(scene_type), intent(in) :: first, scene
    type(identify_par), allocatable :: unknowns(:)
    type(scene_type) :: here                     !! the search may change what it is asked about
    type(message_list) :: messages               !! what is not found is no error
    integer, allocatable :: places(:)
    integer :: i
    places = positions_of(first%groups, 'identify')
    allocate (unknowns(size(places)))
    here%groups = scene%groups
    do i = 1, size(places)
      call find_unknown(first%groups(places(i)), here%groups, unknowns(i), messages)
      unknowns(i)%start = first%unknowns(i)%start
      if (unknowns(i)%group == 0) cycle
      if (.not. scene%groups(unknowns(i)%group)%values(unknowns(i)%value)%given) unknowns(i)%group = 0
    end do
  end function unknowns_in

end module bw_scene_states
