module bw_lost_lines
  !! Lines none of which is a mode of the beam, so that nothing is identified. Their frequencies beside those of modes
  !! indicate the cause: if they are a thousand times lower, the unit of time is wrong.
  use bw_measured_state, only: measured_state, state_modes
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: are_lost, lost_text

  integer, parameter :: looked_at = 20           !! of the first modes

contains

  pure logical function are_lost(states)
    !! Return whether no line of any state is taken for a mode.
    type(measured_state), intent(in) :: states(:)
    integer :: i
    are_lost = all([(all(states(i)%mode_of == 0), i=1, size(states))])
  end function are_lost

  function lost_text(state, values) result(text)
    !! Report the lines of a state and its first modes.
    type(measured_state), intent(inout) :: state
    real(dp), intent(in) :: values(:)            !! of the unknowns
    character(:), allocatable :: text
    type(state_modes) :: modes
    integer :: i
    if (size(state%lines%frequency) == 0) then
      text = 'the record has no line'
      return
    end if
    text = 'no line is a mode of the beam: lines lie from '//in_hertz(state%lines%frequency(1))//' to '// &
      in_hertz(state%lines%frequency(size(state%lines%frequency)))//' Hz'
    call state%modes_at(values, [(i, i=1, min(looked_at, state%most_modes))], modes)
    if (.not. modes%found) return
    text = text//', modes 1 to '//text_of(size(modes%number))//' from '//in_hertz(modes%frequency(1))//' to '// &
      in_hertz(modes%frequency(size(modes%frequency)))//' Hz. Are the times of the record in s (record%time_scale)?'
  end function lost_text

  pure function in_hertz(frequency) result(text)
    real(dp), intent(in) :: frequency            !! rad/s
    character(:), allocatable :: text
    text = shortest(frequency/two_pi, 4)
  end function in_hertz

end module bw_lost_lines
