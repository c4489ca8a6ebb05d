module bw_scene_scales
  !! Scales that follow from the inputs of a case and have to fit into double precision, so that no later stage
  !! overflows for a reason that was visible in the scene. They are formed in extended precision.
  use bw_beam_par, only: beam_mass
  use bw_damping_par, only: by_ratio
  use bw_input_values, only: position_of
  use bw_kinds, only: dp, qp
  use bw_representable, only: check_product
  use bw_scene, only: scene_type
  use bw_scene_messages, only: message_list
  use bw_scene_method, only: check_method
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: check_scales

  real(qp), parameter :: longest_phase = 1e18_qp   !! rad: what 32 digits leave of it is right to 1e-13
  real(qp), parameter :: pi = 3.14159265358979323846264338327950288_qp

contains

  pure subroutine check_scales(scene, messages)
    !! Report the scales of a case that are out of range, at the line of the group that they come from.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    real(qp) :: lowest, highest
    lowest = frequency_scale(scene)
    highest = lowest*(pi*max(scene%modes%before, scene%modes%after))**2
    call check(scene, 'beam', beam_mass(scene%beam), 'the mass of the beam', messages)
    call check(scene, 'beam', lowest**2, 'EI/(rho A l^4), the square of the frequency scale,', messages)
    call check(scene, 'beam', highest**2, 'the square of the highest frequency', messages)
    if (allocated(scene%rotation)) then
      call check(scene, 'rotation', at_least_1(real(scene%rotation%angular_velocity, qp)**2), &
                 'the square of angular_velocity', messages)
    end if
    if (allocated(scene%damping)) then
      call check(scene, 'damping', at_least_1(highest_damping(scene, highest)**2), 'the square of the highest damping', &
                 messages)
    end if
    if (allocated(scene%impact)) then
      call check(scene, 'impact', at_least_1(scene%impact%mass*real(scene%impact%approach_velocity, qp)**2), &
                 'the kinetic energy of the mass', messages)
    end if
    call check_method(scene, messages)
    if (allocated(scene%response)) call check_times(scene, highest, messages)
  end subroutine check_scales

  pure subroutine check_times(scene, highest, messages)
    type(scene_type), intent(in) :: scene
    real(qp), intent(in) :: highest              !! frequency [rad/s]
    type(message_list), intent(inout) :: messages
    real(qp) :: duration
    duration = scene%response%duration
    call check(scene, 'response', duration/scene%response%samples, 'the time between samples', messages)
    call check(scene, 'response', at_least_1(highest*duration), 'the phase of the highest mode at the end', messages)
    if (highest*duration > longest_phase) call messages%add( &
      scene%groups(position_of(scene%groups, 'response'))%line_of('duration'), 'response%duration', &
      'is so long that the phase of the highest mode is lost; accepted: up to '// &
      shortest(real(longest_phase/highest, dp), 2)//' s')
    if (allocated(scene%rotation)) then
      call check(scene, 'response', at_least_1(abs(scene%rotation%angular_velocity)*duration), 'the angle turned', &
                 messages)
    end if
  end subroutine check_times

  pure subroutine check(scene, group, product, what, messages)
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: group, what
    real(qp), intent(in) :: product
    type(message_list), intent(inout) :: messages
    integer :: line
    line = scene%groups(position_of(scene%groups, group))%line
    call check_product(product, line, '&'//group, what, messages)
  end subroutine check

  elemental real(qp) function at_least_1(value)
    !! For products of which only overflow matters.
    real(qp), intent(in) :: value
    at_least_1 = max(1.0_qp, value)
  end function at_least_1

  pure real(qp) function highest_damping(scene, highest) result(damping)
    !! c of the highest mode [1/s].
    type(scene_type), intent(in) :: scene
    real(qp), intent(in) :: highest              !! frequency [rad/s]
    associate (law => scene%damping)
      if (by_ratio(law)) then
        damping = 2*law%ratio*highest
      else
        damping = law%mass_proportional + law%stiffness_proportional*highest**2
      end if
    end associate
  end function highest_damping

  pure real(qp) function frequency_scale(scene)
    !! h/l² = √(EI/(ρA))/l² [rad/s]; mode k of the beam has nearly (h/l²)·((k − ½)π)².
    type(scene_type), intent(in) :: scene
    associate (beam => scene%beam)
      frequency_scale = sqrt(real(beam%youngs_modulus, qp)/beam%density*beam%second_moment/beam%area) &
                        /real(beam%length, qp)**2
    end associate
  end function frequency_scale

end module bw_scene_scales
