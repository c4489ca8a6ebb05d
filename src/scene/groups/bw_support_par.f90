module bw_support_par
  !! `&support` and `&tip_support`: springs between an end of the beam and the rotating frame.
  use bw_input_name, only: input_group, input_name, not_negative, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  implicit none (type, external)
  private
  public :: build_support, check_support, support_text

  type, public :: support_par
    !! An unallocated stiffness is rigid.
    real(dp), allocatable :: stiffness              !! k_v against deflection of the end [N/m], ≥ 0
    real(dp), allocatable :: rotational_stiffness   !! k_θ against its rotation [N m/rad], ≥ 0
  end type support_par

  type(input_group), parameter, public :: support_group = input_group( &
    'support', is_effect=.true., builds_up=.true., changes_shapes=.true., absent='the root is clamped', &
    physics='Springs at the root: the shear force there is `stiffness` times the deflection, the bending moment '// &
    '`rotational_stiffness` times the slope. Real clamps are elastic, which lowers every frequency.', &
    example='&support rotational_stiffness = 2e5 /        ! pinned against deflection, and a clamp that turns by 1 rad '// &
    'under 2e5 N m', &
    rules='Give one or both; a name that is left out is rigid. A `rotational_stiffness` of 0 is a hinge; both 0 is a free end. '// &
    'Springs are fixed to the rotating frame. A beam that rotates in its plane must be held by a spring, here or of a `&body`. '// &
    'If it can turn freely about its root it is unstable, because only tension would restore it.')

  type(input_name), parameter, public :: support_names(*) = [ &
    input_name('support', 'stiffness', real_input, 'N m-1', not_negative, swept=.true., &
               meaning='stiffness against deflection of the root'), &
    input_name('support', 'rotational_stiffness', real_input, 'N m rad-1', not_negative, swept=.true., &
               meaning='stiffness against rotation of the root')]

  type(input_group), parameter, public :: tip_support_group = input_group( &
    'tip_support', is_effect=.true., builds_up=.true., changes_shapes=.true., absent='the tip is free', &
    physics='Springs at the tip, as `&support` has them at the root: a beam between two bearings, or an arm that rests on '// &
    'a stop.', &
    example='&support rotational_stiffness = 0 /          ! a beam on two pins|&tip_support rotational_stiffness = 0 /', &
    rules='A name that is left out is rigid: with neither name the tip is clamped, with a `rotational_stiffness` of 0 it is '// &
    'pinned, with a `stiffness` of 0 it slides. Springs are fixed to the rotating frame. The tip can move along the beam, so '// &
    'that the tension of `&stiffening` is that of a free tip. A rigidly held tip cannot be struck.')

  type(input_name), parameter, public :: tip_support_names(*) = [ &
    input_name('tip_support', 'stiffness', real_input, 'N m-1', not_negative, swept=.true., &
               meaning='stiffness against deflection of the tip'), &
    input_name('tip_support', 'rotational_stiffness', real_input, 'N m rad-1', not_negative, swept=.true., &
               meaning='stiffness against rotation of the tip')]

contains

  pure subroutine check_support(support, messages)
    !! Check that a stiffness is given: a root with two rigid springs is clamped.
    type(group_values), intent(in) :: support
    type(message_list), intent(inout) :: messages
    if (any(support%values%given)) return
    call messages%add(support%line, '&support', 'has neither stiffness nor rotational_stiffness; accepted: one or both; '// &
                      'without the group the root is clamped')
  end subroutine check_support

  pure type(support_par) function build_support(values) result(support)
    !! Build a support from checked values.
    type(group_values), intent(in) :: values
    if (values%known('stiffness')) support%stiffness = values%number('stiffness')
    if (values%known('rotational_stiffness')) support%rotational_stiffness = values%number('rotational_stiffness')
  end function build_support

  pure function support_text(values) result(text)
    !! Return the text of a report: `soft root (deflection 1e6 N/m, turning hinged)`, `held tip (deflection rigid, turning free)`.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    logical :: root
    root = values%group == 'support'
    text = merge('soft root', 'held tip ', root)
    text = trim(text)//' (deflection '//word(values, 'stiffness', ' N/m', 'free')//', turning '// &
      word(values, 'rotational_stiffness', ' N m/rad', trim(merge('hinged', 'free  ', root)))//')'
  end function support_text

  pure function word(values, name, unit, free)
    !! Return a stiffness, or what its absence means.
    type(group_values), intent(in) :: values
    character(*), intent(in) :: name, unit, free
    character(:), allocatable :: word
    if (.not. values%known(name)) then
      word = 'rigid'
    else if (values%number(name) == 0.0_dp .and. .not. values%is_swept(name)) then
      word = free
    else
      word = values%number_or_swept(name, unit)
    end if
  end function word

end module bw_support_par
