module bw_contact_par
  !! `&contact`: an impact of finite duration, while mass and beam are pressed together.
  use bw_beam_par, only: beam_par, beam_piece, section_at
  use bw_constants, only: pi
  use bw_input_name, only: input_group, input_name, integer_input, not_negative, number_range, positive, real_input
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: build_contact, check_contact, check_contact_place, complete_contact, contact_text

  type, public :: contact_par
    real(dp) :: stiffness = 0.0_dp      !! K [N/m^p], > 0, given or by Hertz's law
    real(dp) :: exponent = 1.5_dp       !! p, ≥ 1
    real(dp) :: damping = 0.0_dp        !! c [s/m], ≥ 0
    real(dp) :: radius = 0.0_dp         !! of the sphere [m]; 0: the stiffness is given
    real(dp) :: surface_radius = 0.0_dp !! of the beam at the place of impact [m]; 0: flat
    integer :: max_contacts = 1000      !! number of contacts that are followed; the motion ends at the next
  end type contact_par

  type(input_group), parameter, public :: contact_group = input_group( &
    'contact', needs='impact response', excludes='recontact', is_event=.true., &
    absent='the blow is instantaneous, as in the paper', &
    physics='A contact of finite duration. The mass and the beam are pressed into each other with the force F = K d^p (1 + '// &
    'damping d''), where d is the indentation; the force never pulls. Hertz''s law for elastic bodies has p = 3/2.', &
    example='&impact mass = 0.515, approach_velocity = 1 /|&contact radius = 0.025 /                     ! a steel '// &
    'ball|&response duration = 0.02, samples = 4096, bending_moment = .true. /', &
    rules='Give `stiffness` K and `exponent` p (1: a linear stop), or the `radius` of a sphere. K then follows from Hertz''s '// &
    'law with the moduli of sphere and beam, on a flat side (`surface_radius` = 0) or across the axis of a round beam. The '// &
    'mass moves in a guide that turns with the hub. Every further contact is followed, also while bodies come and leave. The '// &
    'rebound is a result: `restitution` of `&impact` is refused. If there are more than `max_contacts` contacts, the histories '// &
    'are missing from the next one on.')

  type(input_name), parameter, public :: contact_names(*) = [ &
    input_name('contact', 'stiffness', real_input, 'N', positive, swept=.true., &
               excludes='radius youngs_modulus poisson_ratio beam_poisson_ratio surface_radius', &
               meaning='K of F = K d^p: the force at d = 1 m'), &
    input_name('contact', 'exponent', real_input, '1', number_range(1.0_dp, 10.0_dp), '1.5', swept=.true., excludes='radius', &
               meaning='p of F = K d^p'), &
    input_name('contact', 'radius', real_input, 'm', positive, swept=.true., excludes='stiffness exponent', &
               meaning='radius of the striking sphere'), &
    input_name('contact', 'youngs_modulus', real_input, 'Pa', positive, swept=.true., excludes='stiffness', &
               meaning='modulus of the sphere; absent: that of the struck beam'), &
    input_name('contact', 'poisson_ratio', real_input, '1', number_range(-1.0_dp, 0.5_dp, above=.true.), '0.3', swept=.true., &
               excludes='stiffness', meaning='Poisson''s ratio of the sphere'), &
    input_name('contact', 'beam_poisson_ratio', real_input, '1', number_range(-1.0_dp, 0.5_dp, above=.true.), '0.3', &
               swept=.true., excludes='stiffness', meaning='Poisson''s ratio of the beam'), &
    input_name('contact', 'surface_radius', real_input, 'm', not_negative, swept=.true., excludes='stiffness', &
               meaning='radius across, 0: flat; absent: diameter/2, else flat'), &
    input_name('contact', 'damping', real_input, 's m-1', not_negative, '0', swept=.true., &
               meaning='Hunt and Crossley''s constant in (1 + damping d'')'), &
    input_name('contact', 'max_contacts', integer_input, '1', number_range(1.0_dp, 1e6_dp), '1000', swept=.true., &
               meaning='largest number of contacts')]

contains

  pure subroutine check_contact(contact, messages)
    !! Check that the stiffness is given in one of its two ways.
    type(group_values), intent(in) :: contact
    type(message_list), intent(inout) :: messages
    if (contact%given('stiffness') .or. contact%given('radius')) return
    call messages%add(contact%line, '&contact', 'has neither stiffness nor radius; accepted: one of them')
  end subroutine check_contact

  pure subroutine check_contact_place(groups, messages)
    !! Check that Hertz's law has the beam's material, and that &impact gives no restitution, which is then a result.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    integer :: beam, contact, impact
    contact = position_of(groups, 'contact')
    if (contact == 0) return
    beam = position_of(groups, 'beam')
    if (beam > 0 .and. groups(contact)%given('radius')) then
      if (groups(beam)%given('bending_stiffness')) call messages%add(groups(contact)%line_of('radius'), 'contact%radius', &
        'needs the material of the beam, which mass_per_length and bending_stiffness do not give; accepted: a beam by density, '// &
        'youngs_modulus and a section, or stiffness and exponent in place of radius')
    end if
    impact = position_of(groups, 'impact')
    if (impact == 0) return
    if (groups(impact)%number('restitution') == 0.0_dp .and. .not. groups(impact)%is_swept('restitution')) return
    call messages%add(groups(impact)%line_of('restitution'), 'impact%restitution', &
      'has no meaning with &contact, where the rebound is a result; accepted: without restitution, or without &contact')
  end subroutine check_contact_place

  pure subroutine complete_contact(groups)
    !! Drop values that have no meaning with those given.
    type(group_values), intent(inout) :: groups(:)
    integer :: contact, impact
    contact = position_of(groups, 'contact')
    impact = position_of(groups, 'impact')
    if (impact > 0) call groups(impact)%drop('restitution')
    if (contact == 0) return
    if (groups(contact)%given('stiffness')) then
      call groups(contact)%drop('poisson_ratio')
      call groups(contact)%drop('beam_poisson_ratio')
    else
      call groups(contact)%drop('exponent')
    end if
  end subroutine complete_contact

  pure subroutine build_contact(values, beam, position, contact)
    !! Build a contact from checked values. Omitted values of Hertz's law are those of the beam at the place of impact; at
    !! a joint, of the inner piece.
    type(group_values), intent(in) :: values       !! complete
    type(beam_par), intent(in) :: beam
    real(dp), intent(in) :: position               !! ξ of the place of impact
    type(contact_par), allocatable, intent(out) :: contact
    type(beam_piece) :: struck
    real(dp) :: modulus, own
    allocate (contact)
    contact%damping = values%number('damping')
    contact%max_contacts = values%whole('max_contacts')
    if (values%known('stiffness')) then
      contact%stiffness = values%number('stiffness')
      contact%exponent = values%number('exponent')
      return
    end if
    contact%radius = values%number('radius')
    struck = section_at(beam, position)
    own = struck%youngs_modulus
    if (values%known('youngs_modulus')) own = values%number('youngs_modulus')
    if (struck%round) contact%surface_radius = 0.5_dp*struck%diameter
    if (values%known('surface_radius')) contact%surface_radius = values%number('surface_radius')
    modulus = 1.0_dp/((1.0_dp - values%number('poisson_ratio')**2)/own &
                      + (1.0_dp - values%number('beam_poisson_ratio')**2)/struck%youngs_modulus)
    contact%stiffness = hertz_stiffness(modulus, contact%radius, contact%surface_radius)
  end subroutine build_contact

  pure real(dp) function hertz_stiffness(modulus, radius, surface_radius) result(stiffness)
    !! Return K of a sphere on a cylinder: with curvatures A ≤ B of the gap Ax² + By² and the contact ellipse of eccentricity e,
    !! B/A = ((1 − e²)^(−1)E − K)/(K − E) and K = ⅔πE*√((K − E)/(K³Ae²)), K and E the complete elliptic integrals of e
    !! (Johnson, Contact Mechanics, section 4.2). On a plane it is 4/3 E*√R.
    real(dp), intent(in) :: modulus                !! E*
    real(dp), intent(in) :: radius                 !! of the sphere
    real(dp), intent(in) :: surface_radius         !! of the cylinder; 0: a plane
    real(dp) :: ratio, low, high, m, first, second
    integer :: i
    stiffness = 4.0_dp/3.0_dp*modulus*sqrt(radius)
    if (surface_radius == 0.0_dp) return
    ratio = 1.0_dp + radius/surface_radius         ! B/A
    low = 0.0_dp                                   ! of ln(1/(1 − e²))
    high = 80.0_dp
    do i = 1, 80
      m = 0.5_dp*(low + high)
      call elliptic_integrals(exp(-m), first, second)
      if (exp(m)*second - first < ratio*(first - second)) then
        low = m
      else
        high = m
      end if
    end do
    m = exp(-0.5_dp*(low + high))
    if (1.0_dp - m < 1.0e-6_dp) return             ! a plane to that precision
    call elliptic_integrals(m, first, second)
    stiffness = 2.0_dp/3.0_dp*pi*modulus*sqrt((first - second)/(first**3*(0.5_dp/radius)*(1.0_dp - m)))
  end function hertz_stiffness

  pure subroutine elliptic_integrals(complement, first, second)
    !! Compute the complete integrals K and E by the arithmetic-geometric mean.
    real(dp), intent(in) :: complement             !! 1 − e²
    real(dp), intent(out) :: first, second
    real(dp) :: a, b, c, lack, power
    integer :: i
    a = 1.0_dp
    b = sqrt(complement)
    lack = 0.5_dp*(1.0_dp - complement)
    power = 0.5_dp
    do i = 1, 40
      c = 0.5_dp*(a - b)
      power = 2.0_dp*power
      lack = lack + power*c**2
      c = sqrt(a*b)
      a = 0.5_dp*(a + b)
      b = c
      if (abs(a - b) <= 4*epsilon(a)*a) exit
    end do
    first = pi/(2.0_dp*a)
    second = first*(1.0_dp - lack)
  end subroutine elliptic_integrals

  pure function contact_text(values, contact, one_case) result(text)
    !! Return the text of a report, with the stiffness if it is given or the scene has one case.
    type(group_values), intent(in) :: values
    type(contact_par), intent(in) :: contact
    logical, intent(in) :: one_case
    character(:), allocatable :: text
    text = 'contact ('
    if (values%known('radius')) text = text//'sphere of '//values%number_or_swept('radius', ' m')//surface()//', '
    if (values%known('stiffness')) then
      text = text//'stiffness '//values%number_or_swept('stiffness', ' N/m^p')
    else if (one_case) then
      text = text//'stiffness '//shortest(contact%stiffness, 6)//' N/m^p'
    else
      text = text//'stiffness of Hertz'
    end if
    text = text//', p = '//shortest(contact%exponent, 6)
    if (values%number('damping') > 0.0_dp .or. values%is_swept('damping')) &
      text = text//', damping '//values%number_or_swept('damping', ' s/m')
    text = text//')'
  contains
    pure function surface() result(words)
      character(:), allocatable :: words
      words = ' on a flat side'
      if (values%is_swept('surface_radius')) then
        words = ' on a side of swept radius'
      else if (contact%surface_radius > 0.0_dp) then
        words = ' on a side of radius '//shortest(contact%surface_radius, 4)//' m'
      end if
    end function surface
  end function contact_text

end module bw_contact_par
