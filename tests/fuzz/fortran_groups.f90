module fortran_groups
  !! Each group of a scene as a namelist of Fortran, read by the compiler's own library.
  use bw_kinds, only: dp
  use bw_text, only: lower
  use read_comparison, only: comparison, longest_text, most_texts, most_values, unset, unset_text, unset_whole
  implicit none (type, external)
  private
  public :: read_group

contains

  subroutine read_group(lines, name, both)
    character(*), intent(in) :: lines(:), name
    type(comparison), intent(inout) :: both
    select case (name)
    case ('scene'); call read_header(lines, both)
    case ('beam'); call read_beam(lines, both)
    case ('support'); call read_support(lines, both)
    case ('body'); call read_body(lines, both)
    case ('rotation'); call read_rotation(lines, both)
    case ('stiffening'); call read_stiffening(lines, both)
    case ('shear'); call read_shear(lines, both)
    case ('damping'); call read_damping(lines, both)
    case ('impact'); call read_impact(lines, both)
    case ('capture'); call read_capture(lines, both)
    case ('release'); call read_release(lines, both)
    case ('recontact'); call read_recontact(lines, both)
    case ('modes'); call read_modes(lines, both)
    case ('response'); call read_response(lines, both)
    case ('record'); call read_record(lines, both)
    case ('spectrum'); call read_spectrum(lines, both)
    case ('identify'); call read_identify(lines, both)
    case default; both%differing = 'all its names, for which this test has no namelist,'
    end select
  end subroutine read_group

  subroutine read_header(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    character(longest_text) :: title
    namelist /scene/ title
    title = unset_text
    read (lines, nml=scene, iostat=both%stat)
    call both%same_text('title', title)
  end subroutine read_header

  subroutine read_beam(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp), dimension(most_values) :: length, density, youngs_modulus, diameter, width, height, area, second_moment
    namelist /beam/ length, density, youngs_modulus, diameter, width, height, area, second_moment
    length = unset
    density = unset
    youngs_modulus = unset
    diameter = unset
    width = unset
    height = unset
    area = unset
    second_moment = unset
    read (lines, nml=beam, iostat=both%stat)
    call both%same_list('length', length)
    call both%same_list('density', density)
    call both%same_list('youngs_modulus', youngs_modulus)
    call both%same_list('diameter', diameter)
    call both%same_list('width', width)
    call both%same_list('height', height)
    call both%same_list('area', area)
    call both%same_list('second_moment', second_moment)
  end subroutine read_beam

  subroutine read_support(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: stiffness, rotational_stiffness
    namelist /support/ stiffness, rotational_stiffness
    stiffness = unset
    rotational_stiffness = unset
    read (lines, nml=support, iostat=both%stat)
    call both%same_real('stiffness', stiffness)
    call both%same_real('rotational_stiffness', rotational_stiffness)
  end subroutine read_support

  subroutine read_body(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: position, mass, mass_ratio, rotary_inertia, stiffness, rotational_stiffness
    namelist /body/ position, mass, mass_ratio, rotary_inertia, stiffness, rotational_stiffness
    position = unset
    mass = unset
    mass_ratio = unset
    rotary_inertia = unset
    stiffness = unset
    rotational_stiffness = unset
    read (lines, nml=body, iostat=both%stat)
    call both%same_real('position', position)
    call both%same_real('mass', mass)
    call both%same_real('mass_ratio', mass_ratio)
    call both%same_real('rotary_inertia', rotary_inertia)
    call both%same_real('stiffness', stiffness)
    call both%same_real('rotational_stiffness', rotational_stiffness)
  end subroutine read_body

  subroutine read_rotation(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: angular_velocity
    character(longest_text) :: plane
    namelist /rotation/ angular_velocity, plane
    angular_velocity = unset
    plane = unset_text
    read (lines, nml=rotation, iostat=both%stat)
    call both%same_real('angular_velocity', angular_velocity)
    call both%same_text('plane', lower(plane))
  end subroutine read_rotation

  subroutine read_stiffening(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: hub_radius
    namelist /stiffening/ hub_radius
    hub_radius = unset
    read (lines, nml=stiffening, iostat=both%stat)
    call both%same_real('hub_radius', hub_radius)
  end subroutine read_stiffening

  subroutine read_shear(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: poisson_ratio, shear_coefficient
    namelist /shear/ poisson_ratio, shear_coefficient
    poisson_ratio = unset
    shear_coefficient = unset
    read (lines, nml=shear, iostat=both%stat)
    call both%same_real('poisson_ratio', poisson_ratio)
    call both%same_real('shear_coefficient', shear_coefficient)
  end subroutine read_shear

  subroutine read_damping(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: ratio, mass_proportional, stiffness_proportional
    namelist /damping/ ratio, mass_proportional, stiffness_proportional
    ratio = unset
    mass_proportional = unset
    stiffness_proportional = unset
    read (lines, nml=damping, iostat=both%stat)
    call both%same_real('ratio', ratio)
    call both%same_real('mass_proportional', mass_proportional)
    call both%same_real('stiffness_proportional', stiffness_proportional)
  end subroutine read_damping

  subroutine read_impact(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: mass, mass_ratio, position, approach_velocity, restitution
    integer :: profile_points
    namelist /impact/ mass, mass_ratio, position, approach_velocity, restitution, profile_points
    mass = unset
    mass_ratio = unset
    position = unset
    approach_velocity = unset
    restitution = unset
    profile_points = unset_whole
    read (lines, nml=impact, iostat=both%stat)
    call both%same_real('mass', mass)
    call both%same_real('mass_ratio', mass_ratio)
    call both%same_real('position', position)
    call both%same_real('approach_velocity', approach_velocity)
    call both%same_real('restitution', restitution)
    call both%same_whole('profile_points', profile_points)
  end subroutine read_impact

  subroutine read_capture(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: rotary_inertia
    namelist /capture/ rotary_inertia
    rotary_inertia = unset
    read (lines, nml=capture, iostat=both%stat)
    call both%same_real('rotary_inertia', rotary_inertia)
  end subroutine read_capture

  subroutine read_release(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: time
    namelist /release/ time
    time = unset
    read (lines, nml=release, iostat=both%stat)
    call both%same_real('time', time)
  end subroutine read_release

  subroutine read_recontact(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    integer :: max_contacts
    namelist /recontact/ max_contacts
    max_contacts = unset_whole
    read (lines, nml=recontact, iostat=both%stat)
    call both%same_whole('max_contacts', max_contacts)
  end subroutine read_recontact

  subroutine read_modes(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    integer :: before, after
    real(dp) :: tolerance
    namelist /modes/ before, after, tolerance
    before = unset_whole
    after = unset_whole
    tolerance = unset
    read (lines, nml=modes, iostat=both%stat)
    call both%same_whole('before', before)
    call both%same_whole('after', after)
    call both%same_real('tolerance', tolerance)
  end subroutine read_modes

  subroutine read_response(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    real(dp) :: duration, points(most_values)
    integer :: samples
    logical :: velocity
    namelist /response/ duration, samples, points, velocity
    duration = unset
    samples = unset_whole
    points = unset
    velocity = .false.                    ! the default
    read (lines, nml=response, iostat=both%stat)
    call both%same_real('duration', duration)
    call both%same_whole('samples', samples)
    call both%same_list('points', points)
    call both%same_flag('velocity', velocity)
  end subroutine read_response

  subroutine read_record(lines, both)
    !! Columns are left out: Fortran has no value that is a name or a number.
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    character(longest_text) :: file(most_texts), quantity(most_texts)
    real(dp) :: time_scale, sample_rate, scale(most_values), points(most_values), start, end
    integer :: i
    namelist /record/ file, time_scale, sample_rate, quantity, scale, points, start, end
    file = unset_text
    time_scale = unset
    sample_rate = unset
    quantity = unset_text
    scale = unset
    points = unset
    start = unset
    end = unset
    read (lines, nml=record, iostat=both%stat)
    call both%same_texts('file', file)
    call both%same_real('time_scale', time_scale)
    call both%same_real('sample_rate', sample_rate)
    call both%same_texts('quantity', [(lower(quantity(i)), i=1, most_texts)])
    call both%same_list('scale', scale)
    call both%same_list('points', points)
    call both%same_real('start', start)
    call both%same_real('end', end)
  end subroutine read_record

  subroutine read_identify(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    character(longest_text) :: parameter, with(most_texts)
    real(dp) :: first, last
    namelist /identify/ parameter, first, last, with
    parameter = unset_text
    with = unset_text
    first = unset
    last = unset
    read (lines, nml=identify, iostat=both%stat)
    call both%same_text('parameter', parameter)
    call both%same_real('first', first)
    call both%same_real('last', last)
    call both%same_texts('with', with)
  end subroutine read_identify

  subroutine read_spectrum(lines, both)
    character(*), intent(in) :: lines(:)
    type(comparison), intent(inout) :: both
    character(longest_text) :: window, ends
    integer :: max_peaks
    real(dp) :: confidence, false_alarm
    namelist /spectrum/ window, max_peaks, confidence, false_alarm, ends
    window = unset_text
    max_peaks = unset_whole
    confidence = unset
    false_alarm = unset
    ends = unset_text
    read (lines, nml=spectrum, iostat=both%stat)
    call both%same_text('window', lower(window))
    call both%same_whole('max_peaks', max_peaks)
    call both%same_real('confidence', confidence)
    call both%same_real('false_alarm', false_alarm)
    call both%same_text('ends', lower(ends))
  end subroutine read_spectrum

end module fortran_groups
