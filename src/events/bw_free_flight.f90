module bw_free_flight
  !! Free motion of beam and mass from an event on: to the next contact, or past all of them. Units of bw_course.
  use bw_contact_motion, only: contact_motion
  use bw_course, only: course_type, free_modes
  use bw_double_double, only: to_dd
  use bw_kinds, only: dp, qp
  use bw_monitor, only: monitor_type
  use bw_next_zero, only: certain, find_zero
  use bw_oscillators, only: moving_state
  use bw_perturbations, only: error_from
  implicit none (type, external)
  private
  public :: coast, fly

contains

  subroutine fly(motion, opening, longest, outcome, course, sway, monitor)
    !! To the next contact, to where one is in doubt, or to the end.
    type(contact_motion), intent(inout) :: motion
    integer, intent(in) :: opening                !! the first derivative of the gap that is not zero now
    real(dp), intent(in) :: longest               !! time from now to the end
    integer, intent(out) :: outcome               !! never, certain or in_doubt (bw_next_zero)
    type(course_type), intent(out) :: course      !! the motion until then
    real(dp), intent(out) :: sway                 !! what the tip's displacement may be in it
    class(monitor_type), intent(inout), optional :: monitor   !! the outcome means nothing where it asks to stop
    type(moving_state) :: from
    from = motion%state
    call find_zero(motion%parts, motion%gap, motion%near, opening, longest, motion%state, outcome, monitor)
    call finish(motion, from, course, sway)
    if (outcome == certain) call motion%near%meet(motion%parts, motion%gap, motion%state)
  end subroutine fly

  subroutine coast(motion, longest, course, sway)
    !! To the end, whatever is in the way.
    type(contact_motion), intent(inout) :: motion
    real(dp), intent(in) :: longest               !! time from now to the end
    type(course_type), intent(out) :: course
    real(dp), intent(out) :: sway                 !! as that of `fly`
    type(moving_state) :: from
    from = motion%state
    call motion%parts%move(real(longest, qp), motion%state)
    call finish(motion, from, course, sway)
  end subroutine coast

  subroutine finish(motion, from, course, sway)
    !! What there is to say of a flight whose end the state has reached.
    type(contact_motion), intent(inout) :: motion
    type(moving_state), intent(in) :: from
    type(course_type), intent(out) :: course
    real(dp), intent(out) :: sway
    real(dp) :: error(size(from%u), 2), start_error
    start_error = error_from(motion%near%lag)
    call motion%near%carry(motion%parts, from, motion%state, error)
    associate (n => motion%modes)
      sway = motion%parts%sway(motion%gap%a(:n), from, motion%state)
      course = course_type(free_modes, to_dd(from%time), real(from%u(:n), dp), real(from%v(:n), dp), &
                           start_error, error(:n, :))
    end associate
  end subroutine finish

end module bw_free_flight
