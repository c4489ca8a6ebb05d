module bw_lost_lines
  !! Lines none of which is a mode of the beam, so that nothing is identified. Their frequencies beside those of modes,
  !! and the factor between them, indicate the cause: 1000 is a wrong unit of time.
  use bw_measured_state, only: measured_state, state_modes, vague_deviation
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_line_assignment, only: assign, frequency_band, pairing
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: are_lost, best_factor, lost_text

  integer, parameter :: looked_at = 20           !! of the first modes

contains

  pure logical function are_lost(states)
    !! Return whether no line of any state is taken for a mode.
    type(measured_state), intent(in) :: states(:)
    integer :: i
    are_lost = all([(all(states(i)%mode_of == 0), i=1, size(states))])
  end function are_lost

  function lost_text(state, values) result(text)
    !! Report the lines of a state, its first modes, and the factor that matches most lines to modes.
    type(measured_state), intent(inout) :: state
    real(dp), intent(in) :: values(:)            !! of the unknowns
    character(:), allocatable :: text
    type(state_modes) :: modes
    real(dp) :: factor
    integer :: i, fitting
    if (size(state%lines%frequency) == 0) then
      text = 'the record has no line'
      return
    end if
    text = 'no line is a mode of the beam: lines lie from '//in_hertz(state%lines%frequency(1))//' to '// &
      in_hertz(state%lines%frequency(size(state%lines%frequency)))//' Hz'
    call state%modes_at(values, [(i, i=1, min(looked_at, state%most_modes))], modes)
    if (.not. modes%found) return
    text = text//', modes 1 to '//text_of(size(modes%number))//' from '//in_hertz(modes%frequency(1))//' to '// &
      in_hertz(modes%frequency(size(modes%frequency)))//' Hz'
    call best_factor(state%lines%frequency, modes%frequency, factor, fitting)
    if (fitting < 2 .or. 2*fitting < size(state%lines%frequency)) return
    text = text//'; if frequencies were '//shortest(factor, 3)//' times as high, '//text_of(fitting)//' of '// &
      text_of(size(state%lines%frequency))//' would be modes to '//shortest(100*vague_deviation, 2)//' %'//unit_text(factor)
  end function lost_text

  pure subroutine best_factor(line, mode, factor, fitting)
    !! Find the factor on line frequencies that matches most lines to modes, and the number that match.
    real(dp), intent(in) :: line(:), mode(:)     !! frequencies, ascending; lines > 0
    real(dp), intent(out) :: factor
    integer, intent(out) :: fitting
    type(frequency_band), parameter :: decade = frequency_band(width=2.3_dp)
    real(dp), parameter :: hardly = 0.1_dp       ! probability that a line is spurious
    type(pairing) :: record
    real(dp) :: penalty, least
    integer :: i, j, k
    record%deviation = 0.0_dp*line
    record%chance = 0.0_dp*line + hardly
    allocate (record%spurious(size(line)), source=.false.)
    record%mode = mode
    factor = 1
    fitting = 0
    least = huge(least)
    do i = 1, size(line)
      do j = 1, size(mode)
        if (.not. mode(j) > 0) cycle
        record%line = line*(mode(j)/line(i))
        call assign(record, decade, vague_deviation/2, penalty)
        if (.not. penalty < least) cycle
        least = penalty
        associate (found => pack([(k, k=1, size(line))], record%mode_of > 0))
          fitting = size(found)
          factor = exp(sum(log(mode(record%mode_of(found))/line(found)))/size(found))
        end associate
      end do
    end do
  end subroutine best_factor

  pure function unit_text(factor) result(text)
    !! Name the unit of time of such a factor; empty if none fits.
    real(dp), intent(in) :: factor
    character(:), allocatable :: text
    real(dp), parameter :: near = log(1.5_dp)    ! unknowns may shift all modes by this much
    character(*), parameter :: units(3) = ['ms', 'us', 'ns'], scales(3) = ['1e-3', '1e-6', '1e-9']
    integer :: k
    text = ''
    do k = 1, size(units)
      if (abs(log(factor) - 3*k*log(10.0_dp)) < near) text = ', as of a record whose times are in '//units(k)// &
        ': record%time_scale = '//scales(k)//' (times as much, if it is given)'
    end do
  end function unit_text

  pure function in_hertz(frequency) result(text)
    real(dp), intent(in) :: frequency            !! rad/s
    character(:), allocatable :: text
    text = shortest(frequency/two_pi, 4)
  end function in_hertz

end module bw_lost_lines
