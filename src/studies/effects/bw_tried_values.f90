module bw_tried_values
  !! The values with which an effect is tried that a scene lacks, derived from the scene.
  use bw_beam_motion, only: case_modes
  use bw_beam_units, only: beam_units, units_of
  use bw_case_modes, only: find_modes
  use bw_constants, only: pi
  use bw_effect_table, only: effect_type, of_duration, of_first_speed, of_section, of_sphere, of_sphere_radius, own_unit, plain
  use bw_input_table, only: name_row, name_table
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_monitor, only: silent_monitor
  use bw_scene, only: scene_type
  use bw_scene_scales, only: own_size
  use bw_shear_par, only: shear_par, usual_coefficient
  use bw_text, only: replaced, shortest, text_of
  implicit none (type, external)
  private
  public :: find_values

  type, public :: tried_speed
    !! A speed typical of the beam.
    real(dp) :: first = missing                    !! by `find_first_speed`, rad/s; missing until it is called
    logical :: grows = .false.                     !! mode 1 is unstable at that speed
  end type tried_speed

contains

  subroutine find_values(scene, effect, speed, values, remark)
    !! Replace `@` in the values and in the remark by the number with which an effect is tried. Numbers scaled by the
    !! beam have three digits.
    type(scene_type), intent(in) :: scene          !! without the effect
    type(effect_type), intent(in) :: effect
    type(tried_speed), intent(inout) :: speed
    character(:), allocatable, intent(inout) :: values
    character(:), allocatable, intent(out) :: remark
    type(shear_par) :: usual
    character(:), allocatable :: digits
    real(dp) :: number
    remark = trim(effect%remark_off)
    if (index(values//remark, '@') == 0) return
    select case (effect%measure)
    case (plain); number = effect%tried
    case (own_unit); number = effect%tried*own_size(unit_of(trim(effect%groups), values), scene%beam)
    case (of_first_speed)
      if (is_missing(speed%first)) call find_first_speed(scene, speed)
      number = effect%tried*speed%first
      if (speed%grows .and. index(remark, '@') > 0) remark = remark//', '//text_of(effect%tried)// &
        ' of the speed at which mode 1 would be unstable'
    case (of_sphere); number = effect%tried*sphere_inertia(scene)
    case (of_sphere_radius); number = effect%tried*sphere_radius(scene)
    case (of_duration); number = effect%tried*scene%response%duration
    case (of_section)
      number = effect%tried*usual_coefficient(usual%poisson_ratio, scene%beam%round)
      remark = remark//', that of a solid '//trim(merge('circle   ', 'rectangle', scene%beam%round))
    end select
    digits = text_of(number)
    if (any(effect%measure == [own_unit, of_first_speed, of_sphere, of_sphere_radius])) digits = shortest(number, 3)
    values = replaced(values, '@', digits)
    remark = replaced(remark, '@', shortest(number, 3))
  end subroutine find_values

  pure function unit_of(group, values) result(unit)
    !! Return the unit of the name that is set.
    character(*), intent(in) :: group
    character(*), intent(in) :: values             !! `name = value`
    character(:), allocatable :: unit
    unit = name_table(name_row(group, values(:index(values, ' =') - 1)))%unit
  end function unit_of

  subroutine find_first_speed(scene, speed)
    !! Find the angular velocity at which mode 1 becomes unstable or, if there is none, one typical of the beam.
    type(scene_type), intent(in) :: scene          !! without rotation
    type(tried_speed), intent(inout) :: speed
    type(beam_units) :: units
    type(case_modes) :: modes
    type(silent_monitor) :: monitor
    units = units_of(scene%beam)
    call find_modes(scene, units, monitor, modes)
    associate (moving => modes%configuration(modes%moving))
      if (.not. allocated(moving%set)) call moving%source%find([1], moving%set)     ! a tolerance holds none of the beam alone
      speed%first = moving%set%critical_speed%hi*units%frequency
    end associate
    speed%grows = speed%first > 0.0_dp
    if (.not. speed%grows) speed%first = units%frequency
  end subroutine find_first_speed

  pure real(dp) function sphere_inertia(scene) result(inertia)
    !! Return the rotary inertia ⅖m_jR² of the mass as a solid sphere of the beam's density, kg m².
    type(scene_type), intent(in) :: scene
    inertia = 0.4_dp*scene%impact%mass*sphere_radius(scene)**2
  end function sphere_inertia

  pure real(dp) function sphere_radius(scene) result(radius)
    !! Return the radius of that sphere, m.
    type(scene_type), intent(in) :: scene
    radius = (0.75_dp*scene%impact%mass/pi/scene%beam%density)**(1.0_dp/3.0_dp)
  end function sphere_radius

end module bw_tried_values
