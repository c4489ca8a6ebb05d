module bw_beam_par
  !! `&beam`: the uniform beam, clamped at its root.
  use bw_input_name, only: input_group, input_name, positive, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp, qp
  use bw_missing, only: missing
  use bw_scene_messages, only: message_list, settle_product
  implicit none (type, external)
  private
  public :: beam_mass, build_beam, check_beam

  type, public :: beam_par
    real(dp) :: length = 0.0_dp          !! l [m], > 0
    real(dp) :: density = 0.0_dp         !! ρ [kg/m³], > 0
    real(dp) :: youngs_modulus = 0.0_dp  !! E [Pa], > 0
    real(dp) :: diameter = missing       !! D of a solid circle [m]; `missing` where area and second moment were given
    real(dp) :: area = 0.0_dp            !! A [m²], given or πD²/4
    real(dp) :: second_moment = 0.0_dp   !! I [m⁴], given or πD⁴/64
    logical :: round = .false.           !! the diameter was given
  end type beam_par

  type(input_group), parameter, public :: beam_group = input_group( &
    'beam', required=.true., absent='an error: every scene has a beam', &
    rules='Give `diameter` for a solid circle, or `area` and `second_moment` for any other section.')

  type(input_name), parameter, public :: beam_names(*) = [ &
    input_name('beam', 'length', real_input, 'm', positive, required=.true., swept=.true., &
               meaning='length from the clamped root to the tip'), &
    input_name('beam', 'density', real_input, 'kg m-3', positive, required=.true., swept=.true., &
               meaning='mass density of the material'), &
    input_name('beam', 'youngs_modulus', real_input, 'Pa', positive, required=.true., swept=.true., &
               meaning='Young''s modulus E'), &
    input_name('beam', 'diameter', real_input, 'm', positive, swept=.true., excludes='area second_moment', &
               meaning='diameter of a solid circular section'), &
    input_name('beam', 'area', real_input, 'm2', positive, swept=.true., excludes='diameter', &
               meaning='area of the section'), &
    input_name('beam', 'second_moment', real_input, 'm4', positive, swept=.true., excludes='diameter', &
               meaning='second moment of area I of the section, bending stiffness E I')]

  real(qp), parameter :: pi = 3.14159265358979323846264338327950288_qp

contains

  pure subroutine check_beam(beam, messages)
    !! A section is needed: a diameter, or area and second moment together.
    type(group_values), intent(in) :: beam
    type(message_list), intent(inout) :: messages
    if (beam%given('diameter')) return
    if (.not. (beam%given('area') .or. beam%given('second_moment'))) then
      call messages%add(0, 'beam%diameter', 'is missing; accepted: diameter, or area and second_moment')
    else if (.not. beam%given('area')) then
      call messages%add(0, 'beam%area', 'is missing; accepted: area and second_moment, or diameter alone')
    else if (.not. beam%given('second_moment')) then
      call messages%add(0, 'beam%second_moment', 'is missing; accepted: area and second_moment, or diameter alone')
    end if
  end subroutine check_beam

  pure subroutine build_beam(values, beam, messages)
    !! From checked values; what is not given follows from what is.
    type(group_values), intent(in) :: values
    type(beam_par), intent(out) :: beam
    type(message_list), intent(inout) :: messages
    beam%length = values%number('length')
    beam%density = values%number('density')
    beam%youngs_modulus = values%number('youngs_modulus')
    beam%round = values%given('diameter')
    if (beam%round) then
      beam%diameter = values%number('diameter')
      call settle_product(pi/4*real(beam%diameter, qp)**2, beam%area, values%line_of('diameter'), &
                          'beam%diameter', 'the area pi/4 D^2', messages)
      call settle_product(pi/64*real(beam%diameter, qp)**4, beam%second_moment, values%line_of('diameter'), &
                          'beam%diameter', 'the second moment of area pi/64 D^4', messages)
    else
      beam%area = values%number('area')
      beam%second_moment = values%number('second_moment')
    end if
  end subroutine build_beam

  elemental real(qp) function beam_mass(beam)
    !! m_i = ρAl [kg], in extended precision from what was given: no product of doubles overflows there.
    type(beam_par), intent(in) :: beam
    real(qp) :: area
    area = beam%area
    if (beam%round) area = pi/4*real(beam%diameter, qp)**2
    beam_mass = real(beam%density, qp)*area*beam%length
  end function beam_mass

end module bw_beam_par
