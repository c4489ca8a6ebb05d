module bw_result_layout
  !! The arrays of a scene's result and their lengths, known before anything is computed.
  use bw_beam_par, only: has_fibre
  use bw_beam_units, only: units_of
  use bw_input_values, only: position_of
  use bw_kinds, only: dp, i8
  use bw_line_windows, only: window_start
  use bw_piece_beam, only: junctions_of
  use bw_record, only: sensor_type
  use bw_scene, only: answers_by_modes, changes_in_time, converges_in_run, has_configurations, is_let_go, is_loaded, scene_type, &
    varies_along_pieces
  use bw_scene_cases, only: case_count
  use bw_scene_pieces, only: pieces_of, struck_beam
  use bw_scene_resolved, only: numeric_input, numeric_inputs
  use bw_stopwatch, only: stage_count
  use bw_timeline, only: most_configurations, most_events
  implicit none (type, external)
  private
  public :: layout_of, has, dimension_length

  character(*), parameter, public :: dimension_names(*) = [character(18) :: 'case', 'mode', 'mode_before', 'profile', 'event', &
    'point', 'time', 'frequency', 'response_frequency', 'junction', 'peak', 'window', 'candidate', 'pooled', 'piece', 'station', &
    'body', 'force', 'base', 'configuration', 'point_too', 'unknown', 'unknown_too', 'letter', 'parameter_letter', 'note_letter', &
    'stage', 'contact_sample', 'quantile']

  real(dp), parameter, public :: quantile_levels(*) = [0.0_dp, 0.05_dp, 0.25_dp, 0.5_dp, 0.75_dp, 0.95_dp, 1.0_dp]
    !! of a design: 0 is the smallest value, 1 the largest
  integer, parameter, public :: contact_samples = 128   !! of the force in a contact
  integer, parameter :: swept_contacts = 16         !! contacts stored for each case of a sweep
  integer, parameter :: usual_profile = 201         !! points along the beam without an impact
  integer(i8), parameter :: most_shape_numbers = 200000
    !! numbers of all mode shapes that a result holds unless requested: 1.6 MB, 49 cases of 20 modes

  integer, parameter, public :: most_candidates = 32    !! rejected candidates for lines stored for a record, most likely first
  integer, parameter :: note_letters = 1000             !! length of the notes of a case in a sweep
  integer, parameter :: parameter_letters = 64          !! length of the name of an unknown, or of its unit

  type, public :: record_layout
    !! The part of a record's layout that only its files tell.
    type(sensor_type), allocatable :: sensors(:)         !! of the first file
    logical :: placed = .false.                          !! all sensors have positions
    character(:), allocatable :: unit                    !! of all sensors; `1` if they differ
    character(:), allocatable :: checksums               !! of the files
    integer :: longest = 0                               !! most samples of a case on an even grid
    real(dp) :: duration = 0                             !! of the longest case [s]
    real(dp), allocatable :: times(:)                    !! since the first sample [s]
    logical :: stretched = .false.                       !! each interval of time has two values, smallest and largest
    real(dp), allocatable :: frequencies(:)              !! Hz
  end type record_layout

  type, public :: result_layout
    !! Lengths and contents of a result. A length of 0 means that nothing has this dimension.
    integer :: cases = 0              !! 0: no sweep, so no dimension `case`
    integer :: modes = 0              !! most of any case
    integer :: modes_before = 0
    integer :: profile = 0
    integer :: events = 0
    integer :: points = 0
    integer :: samples = 0
    integer :: frequencies = 0
    integer :: answer_frequencies = 0 !! of a harmonic force
    character(12) :: answer = ''      !! response quantity: displacement, velocity or acceleration
    logical :: by_modes = .false.     !! the response is a modal sum, and has an error estimate
    integer :: junctions = 0          !! bodies and steps within the beam, which transmit and reflect waves
    integer :: peaks = 0
    integer :: pieces = 0             !! of a beam that has several
    integer :: stations = 0           !! of a beam that tapers
    integer :: bodies = 0
    integer :: forces = 0
    integer :: bases = 0
    integer :: configurations = 0     !! of a beam that changes in time
    integer :: unknowns = 0           !! identified inputs
    logical :: modelled = .false.     !! a record's lines are compared with the modes of its beam
    logical :: velocity = .false.     !! histories of velocity are requested
    logical :: bending_moment = .false.   !! histories of moments are requested
    logical :: bending_stress = .false.   !! stresses follow from moments
    logical :: acceleration = .false.     !! histories of acceleration are requested
    logical :: shear_force = .false.      !! histories of shear force are requested
    logical :: hub = .false.          !! the hub is free to turn
    logical :: continuum = .false.    !! errors of displacements against all modes are bounded
    logical :: estimates = .false.    !! errors of histories are estimated
    logical :: contacts = .false.     !! histories go through contacts, which amplify errors
    integer :: contact_samples = 0    !! force samples of each lasting contact
    logical :: struck = .false.       !! the impact is instantaneous
    logical :: modal_model = .false.  !! the modal model is exported
    logical :: mode_shapes = .false.  !! mode shapes are few enough to be stored
    integer :: middle = 0             !! index of the point ξ = 0.5; 0 if none
    integer :: tip = 0                !! index of the point ξ = 1; 0 if none
    logical :: of_record = .false.    !! histories are measured, not simulated
    type(record_layout), allocatable :: record   !! unallocated until its files are read (bw_record_plan)
    logical :: of_plain_beam = .false.           !! the beam of a record is known, and its waves follow Eq. 3
    integer :: windows = 0            !! time windows of a record
    integer :: candidates = 0
    logical :: hammer = .false.       !! the impact force is measured
    character(:), allocatable :: load_checksums  !! of load files (bw_load_courses); unallocated: none
    integer :: quantiles = 0          !! levels over the cases of a design
    integer :: pooled = 0             !! lines shared by repeats, at most; 0: no repeats, or another sweep as well
  end type result_layout

contains

  pure type(result_layout) function layout_of(scene) result(layout)
    !! Return the layout of a scene's result.
    type(scene_type), intent(in) :: scene
    if (size(scene%sweeps) > 0) layout%cases = int(case_count(scene))
    layout%of_record = allocated(scene%record)
    if (allocated(scene%beam%pieces)) layout%pieces = size(scene%beam%pieces)
    if (layout%pieces == 1) layout%pieces = 0
    if (allocated(scene%beam%outer)) layout%stations = size(scene%beam%outer) + 1
    if (allocated(scene%bodies)) layout%bodies = size(scene%bodies)
    if (allocated(scene%forces)) layout%forces = size(scene%forces)
    if (allocated(scene%bases)) layout%bases = size(scene%bases)
    if (allocated(scene%unknowns)) layout%unknowns = size(scene%unknowns) + scene%further_unknowns
    if (layout%of_record) then
      layout%peaks = scene%spectrum%max_peaks
      layout%windows = size(window_start)
      layout%of_plain_beam = position_of(scene%groups, 'beam') > 0 .and. .not. (allocated(scene%shear) .or. &
        varies_along_pieces(scene) .or. (allocated(scene%beam%pieces) .and. scene%spectrum%ends /= 'model'))
      layout%candidates = most_candidates
      layout%hammer = allocated(scene%record%force)
      if (size(scene%sweeps) == 1 .and. all(scene%sweeps%implied)) layout%pooled = layout%peaks
      if (int(usual_profile, i8)*layout%peaks*max(1, layout%cases) <= most_shape_numbers) layout%profile = usual_profile
      return
    end if
    if (allocated(scene%design)) layout%quantiles = size(quantile_levels)
    layout%modal_model = scene%modes%modal_model
    layout%hub = allocated(scene%hub)
    layout%struck = allocated(scene%impact) .and. .not. allocated(scene%contact)
    if (has_configurations(scene)) layout%configurations = most_configurations(scene)
    call count_modes(scene, layout)
    call plan_profile(scene, layout)
    if (allocated(scene%contact)) then
      layout%contact_samples = contact_samples
      layout%events = largest(scene, 'contact', 'max_contacts', scene%contact%max_contacts)
      if (layout%cases > 0) layout%events = min(layout%events, swept_contacts)
      layout%events = layout%events + most_events(scene, 0) - 1      ! lasting contacts replace the impact
    else if (allocated(scene%recontact)) then
      layout%events = most_events(scene, largest(scene, 'recontact', 'max_contacts', scene%recontact%max_contacts))
    else
      layout%events = most_events(scene, 0)
    end if
    if (allocated(scene%frequency_response)) then
      layout%points = size(scene%frequency_response%points)
      layout%answer_frequencies = size(scene%frequency_response%frequency)
      layout%answer = scene%frequency_response%quantity
      layout%by_modes = answers_by_modes(scene)
      layout%junctions = junction_count(scene)
    end if
    if (.not. allocated(scene%response)) return
    layout%points = size(scene%response%points)
    layout%samples = scene%response%samples
    layout%velocity = scene%response%velocity
    layout%bending_moment = scene%response%bending_moment
    layout%acceleration = scene%response%acceleration
    layout%shear_force = scene%response%shear_force
    layout%bending_stress = layout%bending_moment .and. has_fibre(scene%beam)
    layout%continuum = (allocated(scene%capture) .and. .not. converges_in_run(scene)) .or. &
      (is_loaded(scene) .and. .not. (allocated(scene%impact) .or. changes_in_time(scene))) .or. is_let_go(scene)
    layout%contacts = allocated(scene%recontact) .or. allocated(scene%contact)
    layout%estimates = layout%continuum .or. layout%contacts .or. changes_in_time(scene)
    layout%middle = findloc(scene%response%points, 0.5_dp, dim=1)
    layout%tip = findloc(scene%response%points, 1.0_dp, dim=1)
    if (.not. allocated(scene%spectrum)) return
    layout%frequencies = layout%samples/2 + 1
    if (layout%middle > 0 .and. layout%tip > 0) layout%peaks = scene%spectrum%max_peaks
  end function layout_of

  pure subroutine count_modes(scene, layout)
    !! Set mode counts to the largest of any case; they vary if a count is swept.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(inout) :: layout
    integer :: before, after
    before = largest(scene, 'modes', 'before', scene%modes%before)
    after = largest(scene, 'modes', 'after', scene%modes%after)
    layout%modes = max(before, after)
    if (allocated(scene%capture) .and. .not. has_configurations(scene)) layout%modes = after
    layout%modes_before = merge(before, 0, allocated(scene%capture))      ! 0 with a tolerance
  end subroutine count_modes

  pure integer function junction_count(scene) result(junctions)
    !! Count junctions; with sweeps an upper bound for all cases.
    type(scene_type), intent(in) :: scene
    type(struck_beam) :: pieces
    junctions = 0
    if (varies_along_pieces(scene)) return
    if (size(scene%sweeps) > 0) then
      if (allocated(scene%beam%pieces)) junctions = size(scene%beam%pieces) - 1
      if (allocated(scene%bodies)) junctions = junctions + size(scene%bodies)
      if (allocated(scene%capture)) junctions = junctions + 1
    else
      pieces = pieces_of(scene, units_of(scene%beam), allocated(scene%capture))
      junctions = size(junctions_of(pieces%beam))
    end if
  end function junction_count

  pure subroutine plan_profile(scene, layout)
    !! Set the points along the beam for the velocity jump, and for mode shapes if they are few enough.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(inout) :: layout
    layout%profile = usual_profile
    if (allocated(scene%impact)) layout%profile = scene%impact%profile_points
    layout%mode_shapes = int(layout%profile, i8)*layout%modes*max(1, layout%cases) <= most_shape_numbers
    if (.not. (layout%mode_shapes .or. allocated(scene%impact))) layout%profile = 0
  end subroutine plan_profile

  pure integer function largest(scene, group, name, count)
    !! Return the largest value of a count, which may be swept or follow a swept one.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: group, name
    integer, intent(in) :: count                !! of the first case
    type(numeric_input), allocatable :: inputs(:)
    integer :: i
    largest = count
    inputs = numeric_inputs(scene)
    do i = 1, size(inputs)
      if (inputs(i)%group /= group .or. inputs(i)%name /= name .or. .not. inputs(i)%is_swept) cycle
      largest = nint(maxval(scene%sweeps(inputs(i)%sweeps(1))%values))
    end do
  end function largest

  pure integer function dimension_length(layout, name) result(length)
    !! Return the length of a dimension by its name in the file; 0 if unused.
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: name
    select case (name)
    case ('case'); length = layout%cases
    case ('mode'); length = layout%modes
    case ('mode_before'); length = layout%modes_before
    case ('profile'); length = merge(layout%profile, 0, layout%modelled .or. .not. layout%of_record)
    case ('event'); length = layout%events
    case ('point'); length = layout%points
    case ('point_too'); length = merge(layout%points, 0, layout%modal_model .or. (layout%of_plain_beam .and. layout%unknowns > 0))
    case ('time'); length = layout%samples
    case ('frequency'); length = layout%frequencies
    case ('response_frequency'); length = layout%answer_frequencies
    case ('junction'); length = layout%junctions
    case ('peak'); length = layout%peaks
    case ('window'); length = layout%windows
    case ('candidate'); length = layout%candidates
    case ('pooled'); length = layout%pooled
    case ('letter'); length = letters_of(layout)
    case ('piece'); length = layout%pieces
    case ('station'); length = layout%stations
    case ('body'); length = layout%bodies
    case ('force'); length = layout%forces
    case ('base'); length = layout%bases
    case ('configuration'); length = layout%configurations
    case ('unknown'); length = layout%unknowns
    case ('unknown_too'); length = merge(layout%unknowns, 0, layout%modelled)
    case ('parameter_letter'); length = merge(parameter_letters, 0, layout%modelled .and. layout%unknowns > 0)
    case ('note_letter'); length = merge(note_letters, 0, layout%cases > 0)
    case ('stage'); length = stage_count
    case ('contact_sample'); length = layout%contact_samples
    case ('quantile'); length = layout%quantiles
    case default; length = 0
    end select
  end function dimension_length

  pure integer function letters_of(layout) result(letters)
    !! Return the length of the longest name or unit of a sensor; 0 without sensors.
    type(result_layout), intent(in) :: layout
    integer :: s
    letters = 0
    if (.not. allocated(layout%record)) return
    do s = 1, size(layout%record%sensors)
      letters = max(letters, len(layout%record%sensors(s)%name), len(layout%record%sensors(s)%unit))
    end do
  end function letters_of

  pure recursive logical function has(layout, words) result(there)
    !! Return whether the result has all that the words name: dimensions; `velocity`, `bending_moment`, `bending_stress`,
    !! `acceleration`, `shear_force` (histories of them); `hub` (a free one); `contacts`; `continuum` (displacements
    !! have a proved bound of their error); `estimates` (of their errors); `mode_shapes`; `modal_model`; `blow` (instantaneous
    !! impact); `record` or `simulated`; `hammer` (measured force); `by_modes` (frequency response); `model` (of the
    !! record's beam); `places` (of all points); `waves`.
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: words         !! separated by blanks; empty: always true
    integer :: gap
    gap = index(words, ' ')
    if (gap > 0) then
      there = has(layout, words(:gap - 1))
      if (there) there = has(layout, words(gap + 1:))
      return
    end if
    select case (words)
    case (''); there = .true.
    case ('velocity'); there = layout%velocity
    case ('bending_moment'); there = layout%bending_moment
    case ('acceleration'); there = layout%acceleration
    case ('shear_force'); there = layout%shear_force
    case ('hub'); there = layout%hub
    case ('bending_stress'); there = layout%bending_stress
    case ('mode_shapes'); there = layout%mode_shapes
    case ('modal_model'); there = layout%modal_model
    case ('model'); there = layout%modelled
    case ('hammer'); there = layout%hammer
    case ('record'); there = layout%of_record
    case ('simulated'); there = layout%samples > 0 .and. .not. layout%of_record
    case ('by_modes'); there = layout%by_modes
    case ('places')                           ! positions of the points along the beam
      there = .not. layout%of_record
      if (allocated(layout%record)) there = layout%record%placed
    case ('waves'); there = has(layout, 'places') .and. (layout%of_plain_beam .or. .not. layout%of_record)
    case ('contacts'); there = layout%contacts
    case ('blow'); there = layout%struck
    case ('continuum'); there = layout%continuum
    case ('estimates'); there = layout%estimates
    case default; there = dimension_length(layout, words) > 0
    end select
  end function has

end module bw_result_layout
