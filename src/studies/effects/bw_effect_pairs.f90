module bw_effect_pairs
  !! For each effect two scenes, one with it and one without, all else as in the scene that is studied. One of the two is
  !! that scene itself wherever it can be. An effect that is off is tried with a value that follows from the scene, which
  !! the row's remark says.
  use bw_kinds, only: dp, qp
  use bw_beam_par, only: area_of, beam_mass, beam_par, second_moment_of
  use bw_beam_units, only: beam_units, units_of
  use bw_case_modes, only: find_modes
  use bw_case_result, only: case_modes
  use bw_damping_par, only: usual_ratio
  use bw_effect_list, only: effect_off, effect_on, effect_row
  use bw_missing, only: rounded
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: silent_monitor
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_variant, only: has_group, scene_variants, with_group, with_value, without_group
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: pairs_of

  real(dp), parameter :: tried_speed = 0.4_dp      !! of the speed at which mode 1 would be unstable
  real(dp), parameter :: tried_release = 0.5_dp    !! of the duration
  real(dp), parameter :: tried_mass = 0.01_dp      ! of the beam's
  real(dp), parameter :: tried_shear = 0.85_dp     !! coefficient of a section whose shape is not known: a rectangle's

  type, public :: compared_scenes
    !! All rows, and every scene that they take, each once; the first is the one that is studied.
    type(effect_row), allocatable :: rows(:)       !! in the order in which they are shown
    type(scene_variants) :: variants
  end type compared_scenes

contains

  subroutine pairs_of(scene, list)
    !! Find the pair of scenes for each effect. A new effect is a call here.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(compared_scenes), intent(out) :: list
    character(:), allocatable :: text, never
    integer :: place
    allocate (list%rows(0))
    text = without_group(resolved_text(scene), 'spectrum')
    if (.not. scene%modes%asked) text = with_value(text, 'modes', 'tolerance', '')    ! each variant relaxes its own
    list%variants%file = scene%file
    call list%variants%find(text, place, never)    ! the scene that is studied has been read before and is not refused now
    call pair_rotation(scene, text, list)
    call pair_stiffening(text, list)
    call pair_shear(scene, text, list)
    call pair_group(text, 'damping', 'ratio = '//text_of(usual_ratio), list, &
                    'tried with ratio = '//text_of(usual_ratio))
    call pair_body(scene, text, list)
    call pair_capture(scene, text, list)
    call pair_release(scene, text, list)
    call pair_recontact(text, list)
    call pair_pieces(scene, text, list)
    call pair_support(scene, text, list)
    call pair_group(text, 'body', 'position = 0.5, mass_ratio = '//text_of(tried_mass), list, &
                    'tried with a mass of '//text_of(tried_mass)//' of the beam''s at the midpoint')
    call pair_position(scene, text, list)
  end subroutine pairs_of

  subroutine leave_out(list, effect, reason)
    !! A row of an effect that cannot be tried beside this scene.
    type(compared_scenes), intent(inout) :: list
    character(*), intent(in) :: effect             !! what it is called
    character(*), intent(in) :: reason
    type(effect_row) :: row
    row%effect = effect
    row%remark = reason
    call add_row(list, row)
  end subroutine leave_out

  subroutine add_pair(list, effect, is_on, with, without, remark)
    !! A row of an effect, whose two texts are read. Where one is refused the row is left out, with the first of the reader's
    !! reasons.
    type(compared_scenes), intent(inout) :: list
    character(*), intent(in) :: effect             !! what it is called
    logical, intent(in) :: is_on                   !! in the scene that is studied
    character(*), intent(in) :: with, without, remark
    type(effect_row) :: row
    character(:), allocatable :: reason
    row%effect = effect
    row%state = merge(effect_on, effect_off, is_on)
    row%remark = remark
    call list%variants%find(with, row%place_with, reason)
    call list%variants%find(without, row%place_without, reason)
    if (allocated(reason)) then
      call leave_out(list, effect, reason)
    else
      call add_row(list, row)
    end if
  end subroutine add_pair

  pure subroutine add_row(list, row)
    !! One more row. (Array constructors of such types leak in gfortran 12.)
    type(compared_scenes), intent(inout) :: list
    type(effect_row), intent(in) :: row
    type(effect_row), allocatable :: rows(:)
    integer :: i
    allocate (rows(size(list%rows) + 1))
    do i = 1, size(list%rows)
      rows(i) = list%rows(i)
    end do
    rows(size(rows)) = row
    call move_alloc(rows, list%rows)
  end subroutine add_row

  subroutine pair_group(text, group, values, list, remark)
    !! A row of an effect that is a group: it is taken out where the scene has it, else tried with some values.
    character(*), intent(in) :: text
    character(*), intent(in) :: group
    character(*), intent(in) :: values             !! to try; empty: all defaults
    type(compared_scenes), intent(inout) :: list
    character(*), intent(in) :: remark             !! on what is tried
    if (has_group(text, group)) then
      call add_pair(list, group, .true., text, without_group(text, group), '')
    else
      call add_pair(list, group, .false., with_group(text, group, values), text, remark)
    end if
  end subroutine pair_group

  subroutine pair_pieces(scene, text, list)
    !! Pair a beam of several pieces with a uniform one.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    real(dp), parameter :: softer = 0.9_dp                 ! E of the outer half
    character(:), allocatable :: length, moduli
    associate (beam => scene%beam)
      if (allocated(beam%pieces)) then
        call add_pair(list, 'pieces', .true., text, with_group(text, 'beam', mean_beam(beam)), &
                      'beside a uniform beam of the same length and mass, and of the mean E I')
      else
        length = text_of(0.5_dp*beam%length)
        moduli = text_of(beam%youngs_modulus)//', '//text_of(softer*beam%youngs_modulus)
        call add_pair(list, 'pieces', .false., with_value(with_value(text, 'beam', 'length', length//', '//length), 'beam', &
                                                          'youngs_modulus', moduli), text, &
                      'tried with an outer half whose youngs_modulus is '//text_of(softer)//' of that of the inner one')
      end if
    end associate
  end subroutine pair_pieces

  pure function mean_beam(beam) result(values)
    !! A uniform beam of the length, mass and mean bending stiffness of one of several pieces.
    type(beam_par), intent(in) :: beam
    character(:), allocatable :: values
    real(qp) :: area, length, modulus, second_moment
    associate (piece => beam%pieces)
      length = sum(real(piece%length, qp))
      area = sum(area_of(piece)*piece%length)/length
      second_moment = sum(second_moment_of(piece)*piece%length)/length
      modulus = sum(piece%youngs_modulus*second_moment_of(piece)*piece%length)/length/second_moment
      values = 'length = '//text_of(beam%length)//', density = '//text_of(rounded(beam_mass(beam)/length/area))// &
        ', youngs_modulus = '//text_of(rounded(modulus))//', area = '//text_of(rounded(area))// &
        ', second_moment = '//text_of(rounded(second_moment))
    end associate
  end function mean_beam

  subroutine pair_support(scene, text, list)
    !! Pair a root that gives with a clamped one.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    real(dp), parameter :: tried_stiffness = 100.0_dp      ! of EI/l
    character(:), allocatable :: stiffness
    associate (beam => scene%beam)
      stiffness = shortest(tried_stiffness*beam%youngs_modulus*beam%second_moment/beam%length, 3)
    end associate
    call pair_group(text, 'support', 'rotational_stiffness = '//stiffness, list, &
                    'tried with rotational_stiffness = '//stiffness//' N m/rad, '//shortest(tried_stiffness, 3)//' EI/l')
  end subroutine pair_support

  subroutine pair_position(scene, text, list)
    !! Pair a blow inboard with one at the tip.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    character(*), parameter :: tried = '0.9'
    if (.not. allocated(scene%impact)) then
      call leave_out(list, 'position', 'needs &impact')
    else if (scene%impact%position < 1.0_dp) then
      call add_pair(list, 'position', .true., text, with_value(text, 'impact', 'position', '1'), 'beside a blow at the tip')
    else
      call add_pair(list, 'position', .false., with_value(text, 'impact', 'position', tried), text, &
                    'a blow at xi = '//tried//' beside one at the tip')
    end if
  end subroutine pair_position

  subroutine pair_rotation(scene, text, list)
    !! Pair rotation without tension, with it, and in the other plane.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    character(:), allocatable :: turning, resting, remark
    logical :: holds, is_on
    real(dp) :: speed
    is_on = has_group(text, 'rotation')
    resting = without_group(without_group(text, 'stiffening'), 'rotation')
    turning = without_group(text, 'stiffening')
    remark = 'without tension'
    if (.not. is_on) then
      call find_usual_speed(scene, speed, holds)
      turning = with_group(resting, 'rotation', 'angular_velocity = '//text_of(speed))
      remark = 'tried in plane at '//shortest(speed, 6)//' rad/s'
      if (holds) remark = remark//', '//text_of(tried_speed)//' of the speed at which mode 1 would be unstable'
    end if
    call add_pair(list, 'rotation', is_on, turning, resting, remark)
    remark = 'rotation and stiffening, beside neither of them'
    if (.not. has_group(text, 'stiffening')) then
      turning = with_group(turning, 'stiffening', '')
      remark = remark//'; the tension is that of a hub without radius'
    else
      turning = text
    end if
    call add_pair(list, 'rotation_with_tension', is_on .and. has_group(text, 'stiffening'), turning, resting, remark)
    if (.not. is_on) then
      call leave_out(list, 'out_of_plane', 'needs &rotation')
    else
      call add_pair(list, 'out_of_plane', scene%rotation%plane == 'out', with_value(text, 'rotation', 'plane', "'out'"), &
                    with_value(text, 'rotation', 'plane', "'in'"), 'the rotation, out of the plane of the motion beside in it')
    end if
  end subroutine pair_rotation

  subroutine find_usual_speed(scene, speed, holds)
    !! An angular velocity to try, rad/s, with three digits.
    type(scene_type), intent(in) :: scene          !! that does not rotate
    real(dp), intent(out) :: speed
    logical, intent(out) :: holds                  !! there is a speed at which mode 1 would be unstable, of which it is a part
    type(beam_units) :: units
    type(case_modes) :: modes
    type(silent_monitor) :: monitor
    character(:), allocatable :: digits
    units = units_of(scene%beam)
    call find_modes(scene, units, monitor, modes)
    speed = modes%configuration(size(modes%configuration))%set%critical_speed%hi
    holds = speed > 0.0_dp
    if (.not. holds) speed = 1.0_dp
    digits = shortest(tried_speed*speed*units%frequency, 3)
    read (digits, *) speed
  end subroutine find_usual_speed

  subroutine pair_stiffening(text, list)
    !! Pair the tension beside the same rotation without it.
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    if (has_group(text, 'rotation')) then
      call pair_group(text, 'stiffening', '', list, 'tried with hub_radius = 0')
    else
      call leave_out(list, 'stiffening', 'needs &rotation')
    end if
  end subroutine pair_stiffening

  subroutine pair_shear(scene, text, list)
    !! Pair a beam that shears with one that does not.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    character(*), parameter :: remark = 'tried with poisson_ratio = 0.3 and '
    if (scene%beam%round) then
      call pair_group(text, 'shear', '', list, remark//'the shear_coefficient of a solid circle')
    else
      call pair_group(text, 'shear', 'shear_coefficient = '//text_of(tried_shear), list, &
                      remark//'shear_coefficient = '//text_of(tried_shear)//', a rectangle''s')
    end if
  end subroutine pair_shear

  subroutine pair_body(scene, text, list)
    !! Pair a captured body that has rotary inertia with a point mass.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    character(:), allocatable :: inertia
    if (.not. has_group(text, 'capture')) then
      call leave_out(list, 'body_inertia', 'needs &capture')
    else if (scene%capture%rotary_inertia > 0.0_dp) then
      call add_pair(list, 'body_inertia', .true., text, with_value(text, 'capture', 'rotary_inertia', '0'), '')
    else
      inertia = shortest(sphere_inertia(scene), 3)
      call add_pair(list, 'body_inertia', .false., with_value(text, 'capture', 'rotary_inertia', inertia), text, &
                    'tried with rotary_inertia = '//inertia//' kg m2, a solid sphere of the beam''s density')
    end if
  end subroutine pair_body

  pure real(dp) function sphere_inertia(scene) result(inertia)
    !! The rotary inertia ⅖m_jR² of the mass as a solid sphere of the beam's density, kg m².
    type(scene_type), intent(in) :: scene
    real(dp), parameter :: pi = acos(-1.0_dp)
    associate (mass => scene%impact%mass)
      inertia = 0.4_dp*mass*(0.75_dp*mass/pi/scene%beam%density)**(2.0_dp/3.0_dp)
    end associate
  end function sphere_inertia

  subroutine pair_capture(scene, text, list)
    !! Pair a mass that stays with one that rebounds.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    if (.not. has_group(text, 'impact')) then
      call leave_out(list, 'capture', 'needs &impact')
    else if (.not. has_group(text, 'capture')) then
      call add_pair(list, 'capture', .false., with_group(without_group(text, 'recontact'), 'capture', ''), text, '')
    else if (by_tolerance(scene%modes)) then
      call leave_out(list, 'capture', 'a rebound beside it needs counts of modes, its impulse going to 0 as modes are added')
    else
      call add_pair(list, 'capture', .true., text, &
                    with_value(without_group(without_group(text, 'release'), 'capture'), 'modes', 'after', ''), &
                    'beside a rebound of as many modes as before the capture')
    end if
  end subroutine pair_capture

  subroutine pair_release(scene, text, list)
    !! Pair a mass that leaves with one that stays.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    if (has_group(text, 'capture') .and. has_group(text, 'response')) then
      call pair_group(text, 'release', 'time = '//text_of(tried_release*scene%response%duration), list, &
                      'tried at half of the duration')
    else
      call leave_out(list, 'release', 'needs &capture and &response')
    end if
  end subroutine pair_release

  subroutine pair_recontact(text, list)
    !! Pair a mass that returns with one that does not.
    character(*), intent(in) :: text
    type(compared_scenes), intent(inout) :: list
    if (has_group(text, 'capture')) then
      call leave_out(list, 'recontact', 'excludes &capture')
    else if (has_group(text, 'impact') .and. has_group(text, 'response')) then
      call pair_group(text, 'recontact', '', list, '')
    else
      call leave_out(list, 'recontact', 'needs &impact and &response')
    end if
  end subroutine pair_recontact

end module bw_effect_pairs
