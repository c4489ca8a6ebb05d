module bw_body_par
  !! `&body`: a rigid body that stays at a place of the beam, and springs from there to the rotating frame.
  use bw_input_name, only: input_group, input_name, not_negative, off_the_root, real_input
  use bw_input_values, only: group_values, positions_of
  use bw_kinds, only: dp, qp
  use bw_mass_or_ratio, only: build_mass, check_mass, mass_par
  use bw_scene_messages, only: message_list
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: bodies_text, build_body, check_body

  type, extends(mass_par), public :: body_par
    !! Its mass, as given or derived, and
    real(dp) :: position = 0.0_dp                !! ξ, 0 < ξ ≤ 1
    real(dp) :: rotary_inertia = 0.0_dp          !! J about its place [kg m²], ≥ 0
    real(dp) :: stiffness = 0.0_dp               !! k_v of a spring against deflection [N/m], ≥ 0
    real(dp) :: rotational_stiffness = 0.0_dp    !! k_θ of a spring against turning [N m/rad], ≥ 0
  end type body_par

  type(input_group), parameter, public :: body_group = input_group( &
    'body', repeatable=.true., along='body', is_effect=.true., builds_up=.true., changes_shapes=.true., &
    absent='nothing is attached to the beam', &
    rules='One group for each body, as many as there are. Give `mass` or `mass_ratio`, 0 for springs alone. Springs are fixed '// &
    'to the rotating frame; those at the root belong to `&support`. Several bodies may have one place, also that where the '// &
    'impact strikes. A sweep names a body by its number in the scene, as `body(2)%mass`, which a single one does not need.')

  type(input_name), parameter, public :: body_names(*) = [ &
    input_name('body', 'position', real_input, '1', off_the_root, required=.true., swept=.true., &
               meaning='place on the beam: x/l, 1 at the tip'), &
    input_name('body', 'mass', real_input, 'kg', not_negative, swept=.true., excludes='mass_ratio', &
               meaning='mass of the body'), &
    input_name('body', 'mass_ratio', real_input, '1', not_negative, swept=.true., excludes='mass', &
               meaning='mass over the mass of the beam'), &
    input_name('body', 'rotary_inertia', real_input, 'kg m2', not_negative, '0', swept=.true., &
               meaning='moment of inertia of the body about its place'), &
    input_name('body', 'stiffness', real_input, 'N m-1', not_negative, '0', swept=.true., &
               meaning='of a spring against the deflection there'), &
    input_name('body', 'rotational_stiffness', real_input, 'N m rad-1', not_negative, '0', swept=.true., &
               meaning='of a spring against the turning there')]

  character(*), parameter :: and = ' and '

contains

  pure subroutine check_body(body, messages)
    !! The mass is given, in one of its two ways.
    type(group_values), intent(in) :: body
    type(message_list), intent(inout) :: messages
    call check_mass(body, body%line, ', 0 for springs alone', messages)
  end subroutine check_body

  pure subroutine build_body(values, beam_mass, body, messages)
    !! From checked values.
    type(group_values), intent(in) :: values
    real(qp), intent(in) :: beam_mass            !! m_i [kg], > 0
    type(body_par), intent(out) :: body
    type(message_list), intent(inout) :: messages
    body%position = values%number('position')
    body%rotary_inertia = values%number('rotary_inertia')
    body%stiffness = values%number('stiffness')
    body%rotational_stiffness = values%number('rotational_stiffness')
    call build_mass(values, beam_mass, body%mass_par, messages)
  end subroutine build_body

  pure function bodies_text(groups) result(text)
    !! What a report calls them: `body of 0.2 kg at xi = 0.8`, or of many how many there are.
    type(group_values), intent(in) :: groups(:)  !! of a scene with at least one
    character(:), allocatable :: text
    integer, parameter :: most = 3
    integer, allocatable :: bodies(:)
    integer :: b
    bodies = positions_of(groups, 'body')
    if (size(bodies) > most) then
      text = text_of(size(bodies))//' bodies'
      return
    end if
    text = body_text(groups(bodies(1)))
    do b = 2, size(bodies)
      text = text//', '//body_text(groups(bodies(b)))
    end do
  end function bodies_text

  pure function body_text(values) result(text)
    !! One of them, with what it has of mass, inertia and springs.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    character(:), allocatable :: place
    text = part(values, 'mass', 'body of ', ' kg', ' mass')// &
      part(values, 'mass_ratio', 'body of ', ' of the beam''s mass', ' mass ratio')// &
      part(values, 'rotary_inertia', 'rotary inertia ', ' kg m2', '')// &
      part(values, 'stiffness', 'spring of ', ' N/m', ' stiffness')// &
      part(values, 'rotational_stiffness', 'rotational spring of ', ' N m/rad', ' stiffness')
    if (text == '') text = and//'body without mass'
    place = ' at xi = '//values%number_or_swept('position', '', digits=15)
    if (values%is_swept('position')) place = ' at swept xi'
    text = text(len(and) + 1:)//place
  end function body_text

  pure function part(values, name, what, unit, swept) result(text)
    !! A number with what it is, behind `and`; nothing where it is 0 in every case.
    type(group_values), intent(in) :: values
    character(*), intent(in) :: name
    character(*), intent(in) :: what              !! stands before the number
    character(*), intent(in) :: unit              !! stands behind it
    character(*), intent(in) :: swept             !! stands behind the word `swept`
    character(:), allocatable :: text
    text = ''
    if (.not. values%known(name)) return
    if (values%number(name) == 0.0_dp .and. .not. values%is_swept(name)) return
    text = and//what//values%number_or_swept(name, unit)
    if (values%is_swept(name)) text = text//swept
  end function part

end module bw_body_par
