module bw_effect_pairs
  !! For each effect two scenes, one with it and one without, all else as in the scene that is studied. One of the two is
  !! that scene itself wherever it can be. An effect that is off is tried with a value that follows from the scene, which
  !! the row's remark says.
  use bw_kinds, only: dp
  use bw_beam_units, only: beam_units, units_of
  use bw_effect_list, only: effect_body_inertia, effect_capture, effect_damping, effect_other_plane, effect_recontact, &
    effect_release, effect_rotation, effect_rotation_with_tension, effect_shear, effect_stiffening
  use bw_effect_scenes, only: add_pair, effect_scenes, leave_out, start_scenes
  use bw_frequency_equation, only: root_type, solve_root
  use bw_modes_par, only: by_tolerance
  use bw_scene, only: scene_type
  use bw_scene_edit, only: has_group, with_group, with_value, without_group
  use bw_scene_resolved, only: resolved_text
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: pairs_of

  real(dp), parameter :: tried_speed = 0.4_dp      !! of the speed at which mode 1 would be unstable
  real(dp), parameter :: tried_damping = 0.01_dp   !! ratio
  real(dp), parameter :: tried_release = 0.5_dp    !! of the duration
  real(dp), parameter :: tried_shear = 0.85_dp     !! coefficient of a section whose shape is not known: a rectangle's

contains

  subroutine pairs_of(scene, list)
    !! Rows in the order of their numbers.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(effect_scenes), intent(out) :: list
    character(:), allocatable :: text
    text = without_group(resolved_text(scene), 'spectrum')
    call start_scenes(text, scene%file, list)
    call pair_rotation(scene, text, list)
    call pair_stiffening(text, list)
    call pair_shear(scene, text, list)
    call pair_damping(text, list)
    call pair_body(scene, text, list)
    call pair_capture(scene, text, list)
    call pair_release(scene, text, list)
    call pair_recontact(text, list)
  end subroutine pairs_of

  subroutine pair_rotation(scene, text, list)
    !! Rotation alone, with its tension, and in the other plane.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    character(:), allocatable :: turning, resting, remark
    logical :: is_on
    is_on = has_group(text, 'rotation')
    resting = without_group(without_group(text, 'stiffening'), 'rotation')
    turning = without_group(text, 'stiffening')
    remark = 'without tension'
    if (.not. is_on) then
      turning = with_group(resting, 'rotation', 'angular_velocity = '//text_of(usual_speed(scene)))
      remark = 'tried in plane at '//shortest(usual_speed(scene), 6)//' rad/s, '//text_of(tried_speed)// &
        ' of the speed at which mode 1 would be unstable'
    end if
    call add_pair(list, effect_rotation, is_on, turning, resting, remark)
    remark = 'rotation and stiffening, beside neither of them'
    if (.not. has_group(text, 'stiffening')) then
      turning = with_group(turning, 'stiffening', '')
      remark = remark//'; the tension is that of a hub without radius'
    else
      turning = text
    end if
    call add_pair(list, effect_rotation_with_tension, is_on .and. has_group(text, 'stiffening'), turning, resting, remark)
    if (.not. is_on) then
      call leave_out(list, effect_other_plane, 'needs &rotation')
    else
      call add_pair(list, effect_other_plane, scene%rotation%plane == 'out', with_value(text, 'rotation', 'plane', "'out'"), &
                    with_value(text, 'rotation', 'plane', "'in'"), 'the rotation, out of the plane of the motion beside in it')
    end if
  end subroutine pair_rotation

  pure real(dp) function usual_speed(scene) result(speed)
    !! rad/s, to three digits.
    type(scene_type), intent(in) :: scene
    type(beam_units) :: units
    type(root_type) :: root
    character(:), allocatable :: digits
    real(dp) :: gamma
    gamma = 0.0_dp
    if (allocated(scene%capture)) gamma = scene%impact%mass_ratio
    units = units_of(scene%beam)
    root = solve_root(1, gamma)
    digits = shortest(tried_speed*root%remainder**2*units%frequency, 3)
    read (digits, *) speed
  end function usual_speed

  subroutine pair_stiffening(text, list)
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    if (.not. has_group(text, 'rotation')) then
      call leave_out(list, effect_stiffening, 'needs &rotation')
    else if (has_group(text, 'stiffening')) then
      call add_pair(list, effect_stiffening, .true., text, without_group(text, 'stiffening'), '')
    else
      call add_pair(list, effect_stiffening, .false., with_group(text, 'stiffening', ''), text, 'tried with hub_radius = 0')
    end if
  end subroutine pair_stiffening

  subroutine pair_shear(scene, text, list)
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    if (has_group(text, 'shear')) then
      call add_pair(list, effect_shear, .true., text, without_group(text, 'shear'), '')
    else if (scene%beam%round) then
      call add_pair(list, effect_shear, .false., with_group(text, 'shear', ''), text, &
                    'tried with poisson_ratio = 0.3 and the shear_coefficient of a solid circle')
    else
      call add_pair(list, effect_shear, .false., with_group(text, 'shear', 'shear_coefficient = '//text_of(tried_shear)), &
                    text, 'tried with poisson_ratio = 0.3 and shear_coefficient = '//text_of(tried_shear)// &
                    ', a rectangle''s')
    end if
  end subroutine pair_shear

  subroutine pair_damping(text, list)
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    if (has_group(text, 'damping')) then
      call add_pair(list, effect_damping, .true., text, without_group(text, 'damping'), '')
    else
      call add_pair(list, effect_damping, .false., with_group(text, 'damping', 'ratio = '//text_of(tried_damping)), text, &
                    'tried with ratio = '//text_of(tried_damping))
    end if
  end subroutine pair_damping

  subroutine pair_body(scene, text, list)
    !! The captured body's rotary inertia.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    character(:), allocatable :: inertia
    if (.not. has_group(text, 'capture')) then
      call leave_out(list, effect_body_inertia, 'needs &capture')
    else if (scene%capture%rotary_inertia > 0.0_dp) then
      call add_pair(list, effect_body_inertia, .true., text, with_value(text, 'capture', 'rotary_inertia', '0'), '')
    else
      inertia = shortest(sphere_inertia(scene), 3)
      call add_pair(list, effect_body_inertia, .false., with_value(text, 'capture', 'rotary_inertia', inertia), text, &
                    'tried with rotary_inertia = '//inertia//' kg m2, a solid sphere of the beam''s density')
    end if
  end subroutine pair_body

  pure real(dp) function sphere_inertia(scene) result(inertia)
    !! ⅖m_jR² of a solid sphere of the beam's density.
    type(scene_type), intent(in) :: scene
    real(dp), parameter :: pi = acos(-1.0_dp)
    associate (mass => scene%impact%mass)
      inertia = 0.4_dp*mass*(0.75_dp*mass/pi/scene%beam%density)**(2.0_dp/3.0_dp)
    end associate
  end function sphere_inertia

  subroutine pair_capture(scene, text, list)
    !! A mass that stays beside one that rebounds.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    if (.not. has_group(text, 'impact')) then
      call leave_out(list, effect_capture, 'needs &impact')
    else if (.not. has_group(text, 'capture')) then
      call add_pair(list, effect_capture, .false., with_group(without_group(text, 'recontact'), 'capture', ''), text, '')
    else if (by_tolerance(scene%modes)) then
      call leave_out(list, effect_capture, 'a rebound beside it needs counts of modes, its impulse going to 0 as modes are added')
    else
      call add_pair(list, effect_capture, .true., text, &
                    with_value(without_group(without_group(text, 'release'), 'capture'), 'modes', 'after', ''), &
                    'beside a rebound of as many modes as before the capture')
    end if
  end subroutine pair_capture

  subroutine pair_release(scene, text, list)
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    if (.not. (has_group(text, 'capture') .and. has_group(text, 'response'))) then
      call leave_out(list, effect_release, 'needs &capture and &response')
    else if (has_group(text, 'release')) then
      call add_pair(list, effect_release, .true., text, without_group(text, 'release'), '')
    else
      call add_pair(list, effect_release, .false., &
                    with_group(text, 'release', 'time = '//text_of(tried_release*scene%response%duration)), text, &
                    'tried at half of the duration')
    end if
  end subroutine pair_release

  subroutine pair_recontact(text, list)
    character(*), intent(in) :: text
    type(effect_scenes), intent(inout) :: list
    if (has_group(text, 'capture')) then
      call leave_out(list, effect_recontact, 'excludes &capture')
    else if (.not. (has_group(text, 'impact') .and. has_group(text, 'response'))) then
      call leave_out(list, effect_recontact, 'needs &impact and &response')
    else if (has_group(text, 'recontact')) then
      call add_pair(list, effect_recontact, .true., text, without_group(text, 'recontact'), '')
    else
      call add_pair(list, effect_recontact, .false., with_group(text, 'recontact', ''), text, '')
    end if
  end subroutine pair_recontact

end module bw_effect_pairs
