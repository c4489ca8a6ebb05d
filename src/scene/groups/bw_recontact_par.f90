module bw_recontact_par
  !! `&recontact`: a mass that has rebounded may strike the beam again.
  use bw_input_name, only: input_group, input_name, integer_input, number_range
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: recontact_par
    integer :: max_contacts = 100       !! number of contacts after the first impact that are followed; the motion ends at the next
  end type recontact_par

  type(input_group), parameter, public :: recontact_group = input_group( &
    'recontact', needs='impact response', excludes='capture', is_event=.true., absent='a rebounded mass never returns', &
    physics='A mass that has rebounded from an instantaneous blow can meet the beam again, any number of times. Each '// &
    'further contact is an instantaneous blow with the same restitution.', &
    example='&impact mass_ratio = 0.2, restitution = 0.5 /|&recontact max_contacts = 20 /|&modes before = 10 /|&response '// &
    'duration = 0.05, samples = 4096 /', &
    rules='After the rebound the mass slides without friction in a straight guide that turns with the hub, and can meet the '// &
    'beam again where it struck. Contacts that follow each other ever faster are merged into one that lasts until the mass is '// &
    'no longer pressed against the beam. If there are more than `max_contacts` contacts, the histories are missing from the '// &
    'next one on.')

  type(input_name), parameter, public :: recontact_names(*) = [ &
    input_name('recontact', 'max_contacts', integer_input, '1', number_range(1.0_dp, 1e6_dp), '100', swept=.true., &
               meaning='largest number of contacts after the impact')]

end module bw_recontact_par
