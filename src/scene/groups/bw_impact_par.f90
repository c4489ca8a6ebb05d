module bw_impact_par
  !! `&impact`: a rigid mass strikes the beam at t = 0.
  use bw_input_name, only: any_number, input_group, input_name, integer_input, not_negative, number_range, off_the_root, &
                           real_input, unit_interval
  use bw_input_values, only: group_values
  use bw_kinds, only: dp, qp
  use bw_mass_or_ratio, only: build_mass, mass_par
  use bw_scene_messages, only: message_list
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: build_impact, impact_text

  type, extends(mass_par), public :: impact_par
    !! The mass m_j, given or derived, and
    real(dp) :: position = 1.0_dp           !! ξ₀, 0 < ξ₀ ≤ 1, place of impact and of capture
    real(dp) :: approach_velocity = 1.0_dp  !! V [m/s] in the rotating frame, of either sign
    real(dp) :: restitution = 0.0_dp        !! e, 0 … 1
    integer :: profile_points = 201         !! points of the velocity jump from root to tip, ≥ 2
  end type impact_par

  type(input_group), parameter, public :: impact_group = input_group( &
    'impact', is_event=.true., absent='nothing strikes the beam: only its modes and wave velocities are computed', &
    physics='A mass strikes the beam at t = 0. Without `&contact` the blow is instantaneous: the impulse H changes the '// &
    'velocities of the modes by Phi_k(xi) H/M_k and that of the mass by -H/m, and the coefficient of restitution gives the '// &
    'velocity of separation.', &
    example='&impact mass = 0.5, position = 0.8, approach_velocity = 2, restitution = 0.3 /', &
    rules='Give `mass` or `mass_ratio`. A positive `approach_velocity` drives the beam towards positive displacement; the '// &
    'opposite sign reverses all motion. `restitution` is the velocity of separation over that of approach: 0 is perfectly '// &
    'plastic, 1 loses no energy. With `&capture` a restitution above 0 adds energy, because the rebounded mass is then given '// &
    'the velocity of the beam; the report says so.')

  type(input_name), parameter, public :: impact_names(*) = [ &
    input_name('impact', 'mass', real_input, 'kg', not_negative, swept=.true., excludes='mass_ratio', &
               meaning='mass of the striking body'), &
    input_name('impact', 'mass_ratio', real_input, '1', not_negative, swept=.true., excludes='mass', &
               meaning='mass over the mass of the beam'), &
    input_name('impact', 'position', real_input, '1', off_the_root, '1', swept=.true., changes_shapes=.true., &
               plain=1.0_dp, meaning='struck place: x/l, 1 at the tip'), &
    input_name('impact', 'approach_velocity', real_input, 'm s-1', any_number, '1', swept=.true., &
               meaning='velocity of the mass at the impact, in the rotating frame'), &
    input_name('impact', 'restitution', real_input, '1', unit_interval, '0', swept=.true., &
               meaning='coefficient of restitution'), &
    input_name('impact', 'profile_points', integer_input, '1', number_range(2.0_dp, 1e6_dp), '201', &
               meaning='points along the beam at which the velocity jump is given')]

contains

  pure subroutine build_impact(values, beam_mass, impact, messages)
    !! Build the impact from checked values.
    type(group_values), intent(in) :: values
    real(qp), intent(in) :: beam_mass                       !! m_i [kg], > 0
    type(impact_par), allocatable, intent(out) :: impact
    type(message_list), intent(inout) :: messages
    allocate (impact)
    impact%position = values%number('position')
    impact%approach_velocity = values%number('approach_velocity')
    impact%restitution = values%number('restitution')
    impact%profile_points = values%whole('profile_points')
    call build_mass(values, beam_mass, impact%mass_par, messages)
  end subroutine build_impact

  pure function impact_text(values, impact, lasts) result(text)
    !! Return the text of a report, with the mass ratio, given or derived.
    type(group_values), intent(in) :: values
    type(impact_par), intent(in) :: impact
    logical, intent(in) :: lasts               !! the contact has a finite duration: the rebound is a result
    character(:), allocatable :: text, ratio
    ratio = shortest(impact%mass_ratio, 6)
    if (values%is_swept('mass') .or. values%is_swept('mass_ratio')) ratio = 'swept'
    text = 'impact'
    if (values%is_swept('position')) then
      text = text//' at swept xi'
    else if (impact%position /= 1.0_dp) then
      text = text//' at xi = '//values%number_or_swept('position', '', digits=15)
    end if
    text = text//' (mass ratio '//ratio//', approach '//values%number_or_swept('approach_velocity', ' m/s')
    if (.not. lasts) text = text//', restitution '//values%number_or_swept('restitution', '')
    text = text//')'
  end function impact_text

end module bw_impact_par
