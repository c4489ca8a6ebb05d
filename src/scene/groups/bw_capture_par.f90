module bw_capture_par
  !! `&capture`: the mass stays attached at the place of impact.
  use bw_input_name, only: input_group, input_name, not_negative, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: capture_text

  type, public :: capture_par
    real(dp) :: rotary_inertia = 0.0_dp   !! J of the body about its place [kg m²], ≥ 0; 0 for a point mass
  end type capture_par

  type(input_group), parameter, public :: capture_group = input_group( &
    'capture', needs='impact', is_event=.true., absent='the mass rebounds', &
    physics='The mass stays on the beam: the modes change from those of the beam alone to those of beam and mass, and the '// &
    'displacement and velocity of the beam are projected onto the new modes.', &
    example='&impact mass_ratio = 0.2 /|&capture rotary_inertia = 1e-4 /')

  type(input_name), parameter, public :: capture_names(*) = [ &
    input_name('capture', 'rotary_inertia', real_input, 'kg m2', not_negative, '0', swept=.true., changes_shapes=.true., &
               meaning='moment of inertia of the captured body about its place')]

contains

  pure function capture_text(values) result(text)
    !! Return the text of a report, with the body's rotary inertia if it has any.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    text = 'capture'
    if (values%number('rotary_inertia') > 0.0_dp .or. values%is_swept('rotary_inertia')) text = text// &
      ' of a body with rotary inertia '//values%number_or_swept('rotary_inertia', ' kg m2')
  end function capture_text

end module bw_capture_par
