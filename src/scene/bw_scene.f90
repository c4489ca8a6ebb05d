module bw_scene
  !! A scene as plain data in SI units: one component per input group, unallocated where the group is absent.
  use bw_beam_par, only: beam_mass, beam_par, build_beam
  use bw_capture_par, only: build_capture, capture_par
  use bw_damping_par, only: build_damping, damping_par
  use bw_impact_par, only: build_impact, impact_par
  use bw_input_values, only: group_values, is_new
  use bw_modes_par, only: build_modes, modes_par
  use bw_recontact_par, only: build_recontact, recontact_par
  use bw_release_par, only: build_release, release_par
  use bw_response_par, only: build_response, response_par
  use bw_rotation_par, only: build_rotation, rotation_par
  use bw_scene_messages, only: message_list
  use bw_scene_par, only: build_header, scene_par
  use bw_shear_par, only: build_shear, shear_par
  use bw_spectrum_par, only: build_spectrum, spectrum_par
  use bw_stiffening_par, only: build_stiffening, stiffening_par
  use bw_sweep_par, only: sweep_par
  implicit none (type, external)
  private
  public :: build_scene

  type, public :: scene_type
    !! What one file asks for. With sweeps, the components are those of the first case.
    character(:), allocatable :: file             !! path as the user wrote it
    character(:), allocatable :: name             !! stem of the file, which names the result
    type(scene_par) :: header                     !! &scene
    type(beam_par) :: beam                        !! &beam
    type(rotation_par), allocatable :: rotation   !! &rotation; absent: the beam does not rotate
    type(stiffening_par), allocatable :: stiffening   !! &stiffening; absent: no tension
    type(shear_par), allocatable :: shear         !! &shear; absent: Euler–Bernoulli
    type(damping_par), allocatable :: damping     !! &damping; absent: undamped
    type(impact_par), allocatable :: impact       !! &impact; absent: modes and wave velocities only
    type(capture_par), allocatable :: capture     !! &capture; absent: the mass rebounds
    type(release_par), allocatable :: release     !! &release; absent: a captured mass stays
    type(recontact_par), allocatable :: recontact !! &recontact; absent: a rebounded mass never returns
    type(modes_par) :: modes                      !! &modes, always settled
    type(response_par), allocatable :: response   !! &response; absent: no time history
    type(spectrum_par), allocatable :: spectrum   !! &spectrum; absent: no spectral analysis
    type(sweep_par), allocatable :: sweeps(:)     !! &sweep, the first varying slowest; of size 0 for one case
    type(group_values), allocatable :: groups(:)  !! all values by name, from which the components were built
  end type scene_type

contains

  pure subroutine build_scene(scene, messages)
    !! Build the components from those of `scene%groups` that are new, which are checked and settled; the others stay as they
    !! are. What follows from the inputs and does not fit into double precision is reported.
    type(scene_type), intent(inout) :: scene
    type(message_list), intent(inout) :: messages
    integer :: before
    before = messages%count
    if (is_new(scene%groups, 'scene')) call build_header(scene%groups, scene%header)
    if (is_new(scene%groups, 'beam')) call build_beam(scene%groups, scene%beam, messages)
    if (messages%count > before) return
    if (is_new(scene%groups, 'rotation')) call build_rotation(scene%groups, scene%rotation)
    if (is_new(scene%groups, 'stiffening')) call build_stiffening(scene%groups, scene%stiffening)
    if (is_new(scene%groups, 'shear')) call build_shear(scene%groups, scene%shear)
    if (is_new(scene%groups, 'damping')) call build_damping(scene%groups, scene%damping)
    if (is_new(scene%groups, 'impact') .or. is_new(scene%groups, 'beam')) &
      call build_impact(scene%groups, beam_mass(scene%beam), scene%impact, messages)
    if (is_new(scene%groups, 'capture')) call build_capture(scene%groups, scene%capture)
    if (is_new(scene%groups, 'release')) call build_release(scene%groups, scene%release)
    if (is_new(scene%groups, 'recontact')) call build_recontact(scene%groups, scene%recontact)
    if (is_new(scene%groups, 'modes')) call build_modes(scene%groups, scene%modes)
    if (is_new(scene%groups, 'response')) call build_response(scene%groups, scene%response)
    if (is_new(scene%groups, 'spectrum')) call build_spectrum(scene%groups, scene%spectrum)
  end subroutine build_scene

end module bw_scene
