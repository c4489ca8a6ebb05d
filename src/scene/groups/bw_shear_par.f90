module bw_shear_par
  !! `&shear`: shear deformation and rotary inertia of the sections (Timoshenko).
  use bw_input_name, only: input_group, input_name, number_range, positive, real_input
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  implicit none (type, external)
  private
  public :: build_shear, check_shear, complete_shear, shear_text, usual_coefficient, usual_shear

  type, public :: shear_par
    real(dp) :: poisson_ratio = 0.3_dp      !! ν
    real(dp) :: shear_coefficient = 0.0_dp  !! κ, given or Cowper's for a solid circle
  end type shear_par

  type(input_group), parameter, public :: shear_group = input_group( &
    'shear', is_effect=.true., changes_shapes=.true., &
    absent='sections stay normal to the axis and have no inertia of their own (Euler-Bernoulli)', &
    physics='Timoshenko''s beam: sections have shear deformation and rotary inertia, which matter if waves are not much longer '// &
    'than the section is high.', &
    example='&shear poisson_ratio = 0.3 /', &
    rules='The shear force is kappa G A times the angle of shear, and the shear modulus is G = E/(2 (1 + nu)), with nu = '// &
    '`poisson_ratio` and kappa = `shear_coefficient`. By default kappa is 6 (1 + nu)/(7 + 6 nu) for the solid circle of a '// &
    '`diameter`, and 10 (1 + nu)/(12 + 11 nu) for the rectangle of `width` and `height` (Cowper 1966). For any other section '// &
    'it must be given. Both numbers apply to every piece.')

  type(input_name), parameter, public :: shear_names(*) = [ &
    input_name('shear', 'poisson_ratio', real_input, '1', number_range(-1.0_dp, 0.5_dp, above=.true.), '0.3', &
               swept=.true., meaning='Poisson''s ratio, from which the shear modulus follows'), &
    input_name('shear', 'shear_coefficient', real_input, '1', positive, swept=.true., &
               meaning='kappa: shear stiffness over G A')]

contains

  pure subroutine check_shear(groups, messages)
    !! Check that Cowper's coefficient is used only for a circle or a rectangle.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    integer :: shear, beam
    shear = position_of(groups, 'shear')
    beam = position_of(groups, 'beam')
    if (shear == 0 .or. beam == 0) return
    if (groups(beam)%given('mass_per_length') .or. groups(beam)%given('bending_stiffness')) then
      call messages%add(groups(shear)%line, '&shear', 'needs material and section of the beam: mass_per_length and '// &
                        'bending_stiffness give neither its shear stiffness nor its rotary inertia; accepted: a beam by '// &
                        'density, youngs_modulus and a section, or without &shear')
      return
    end if
    if (groups(shear)%given('shear_coefficient') .or. groups(beam)%given('diameter')) return
    if (groups(beam)%given('width') .or. groups(beam)%given('height')) return
    if (.not. (groups(beam)%given('area') .or. groups(beam)%given('second_moment'))) return
    call messages%add(0, 'shear%shear_coefficient', 'is missing: the section is given by area and second_moment, which do not '// &
                      'determine its shape; accepted: a real, > 0')
  end subroutine check_shear

  pure subroutine complete_shear(groups)
    !! Derive the coefficient of a circle or a rectangle from Poisson's ratio; it follows a sweep of that ratio.
    type(group_values), intent(inout) :: groups(:)
    integer :: shear, beam
    shear = position_of(groups, 'shear')
    beam = position_of(groups, 'beam')
    if (shear == 0 .or. beam == 0) return
    if (groups(shear)%given('shear_coefficient')) return
    if (.not. (groups(beam)%given('diameter') .or. groups(beam)%given('width'))) return
    associate (ratio => groups(shear)%values(groups(shear)%at('poisson_ratio')))
      if (ratio%known) call groups(shear)%derive('shear_coefficient', usual_coefficient(ratio%numbers(1), &
                                                 groups(beam)%given('diameter')), ratio%sweeps(1))
    end associate
  end subroutine complete_shear

  pure type(shear_par) function build_shear(values) result(shear)
    !! Build the shear from Poisson's ratio and the coefficient, given or derived.
    type(group_values), intent(in) :: values   !! complete
    shear%poisson_ratio = values%number('poisson_ratio')
    if (values%known('shear_coefficient')) shear%shear_coefficient = values%number('shear_coefficient')
  end function build_shear

  pure type(shear_par) function usual_shear() result(shear)
    !! Return the values of a group without input: those of a solid circle.
    shear%shear_coefficient = usual_coefficient(shear%poisson_ratio, .true.)
  end function usual_shear

  elemental real(dp) function usual_coefficient(nu, round) result(coefficient)
    !! Return the coefficient of a solid circle or rectangle: G. R. Cowper, J. Appl. Mech. 33 (1966) 335.
    real(dp), intent(in) :: nu
    logical, intent(in) :: round               !! a circle
    coefficient = 10.0_dp*(1.0_dp + nu)/(12.0_dp + 11.0_dp*nu)
    if (round) coefficient = 6.0_dp*(1.0_dp + nu)/(7.0_dp + 6.0_dp*nu)
  end function usual_coefficient

  pure function shear_text(values) result(text)
    !! Return the text of a report, with both numbers.
    type(group_values), intent(in) :: values   !! complete
    character(:), allocatable :: text
    text = 'shear (Poisson''s ratio '//values%number_or_swept('poisson_ratio', '')//', shear coefficient '// &
      values%number_or_swept('shear_coefficient', '')//')'
  end function shear_text

end module bw_shear_par
