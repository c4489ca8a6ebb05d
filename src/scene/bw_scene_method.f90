module bw_scene_method
  !! Whether the effects of a scene leave the shapes of its modes as closed forms know them.
  use bw_input_values, only: position_of
  use bw_scene, only: scene_type
  use bw_scene_messages, only: message_list
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: changes_shapes, check_method, method_name

  integer, parameter, public :: most_galerkin_modes = 500   !! of a scene that counts them; a few seconds

contains

  pure logical function changes_shapes(scene) result(changes)
    !! Tension, shear, or a body with rotary inertia: its modes have no closed form here.
    type(scene_type), intent(in) :: scene
    changes = allocated(scene%stiffening) .or. allocated(scene%shear)
    if (allocated(scene%capture)) changes = changes .or. scene%capture%rotary_inertia > 0
  end function changes_shapes

  pure function method_name(scene) result(name)
    !! How its modes are found.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: name
    name = 'closed form'
    if (changes_shapes(scene)) name = 'galerkin'
  end function method_name

  pure subroutine check_method(scene, messages)
    !! A Galerkin basis holds so many modes.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    if (.not. changes_shapes(scene)) return
    call check_count(scene, 'before', scene%modes%before, messages)
    call check_count(scene, 'after', scene%modes%after, messages)
  end subroutine check_method

  pure subroutine check_count(scene, name, count, messages)
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: name
    integer, intent(in) :: count
    type(message_list), intent(inout) :: messages
    associate (modes => scene%groups(position_of(scene%groups, 'modes')))
      if (count <= most_galerkin_modes .or. .not. modes%given(name)) return
      call messages%add(modes%line_of(name), 'modes%'//name, 'is '//text_of(count)// &
                        ', more than the basis for stiffening, shear and rotary inertia holds; accepted: 1 to '// &
                        text_of(most_galerkin_modes))
    end associate
  end subroutine check_count

end module bw_scene_method
