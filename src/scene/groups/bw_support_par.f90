module bw_support_par
  !! `&support`: the root is held by springs, to the rotating frame.
  use bw_input_name, only: input_group, input_name, not_negative, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  implicit none (type, external)
  private
  public :: build_support, check_support, support_text

  type, public :: support_par
    !! A stiffness that is unallocated is rigid.
    real(dp), allocatable :: stiffness              !! k_v against the deflection of the root [N/m], ≥ 0
    real(dp), allocatable :: rotational_stiffness   !! k_θ against its turning [N m/rad], ≥ 0
  end type support_par

  type(input_group), parameter, public :: support_group = input_group( &
    'support', is_effect=.true., builds_up=.true., changes_shapes=.true., absent='the root is clamped', &
    rules='Give one or both; a name that is left out is rigid. A `rotational_stiffness` of 0 is a hinge; both 0 is a free end. '// &
    'Springs are fixed to the rotating frame. A beam that rotates in its plane needs something that holds it: a spring here '// &
    'or of a `&body`. One that can turn about its root grows there, as nothing but tension brings it back.')

  type(input_name), parameter, public :: support_names(*) = [ &
    input_name('support', 'stiffness', real_input, 'N m-1', not_negative, swept=.true., &
               meaning='of a spring against the deflection of the root'), &
    input_name('support', 'rotational_stiffness', real_input, 'N m rad-1', not_negative, swept=.true., &
               meaning='of a spring against the turning of the root')]

contains

  pure subroutine check_support(support, messages)
    !! A root of which nothing gives is clamped.
    type(group_values), intent(in) :: support
    type(message_list), intent(inout) :: messages
    if (any(support%values%given)) return
    call messages%add(support%line, '&support', 'has neither stiffness nor rotational_stiffness; accepted: one or both; '// &
                      'without the group the root is clamped')
  end subroutine check_support

  pure type(support_par) function build_support(values) result(support)
    !! From checked values.
    type(group_values), intent(in) :: values
    if (values%known('stiffness')) support%stiffness = values%number('stiffness')
    if (values%known('rotational_stiffness')) support%rotational_stiffness = values%number('rotational_stiffness')
  end function build_support

  pure function support_text(values) result(text)
    !! What a report calls it: `soft root (stiffness 1e6 N/m, turning 2000 N m/rad)`.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    text = 'soft root (deflection '//word('stiffness', ' N/m', 'free')//', turning '// &
      word('rotational_stiffness', ' N m/rad', 'hinged')//')'
  contains
    pure function word(name, unit, free)
      !! A stiffness, or what its absence means.
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
  end function support_text

end module bw_support_par
