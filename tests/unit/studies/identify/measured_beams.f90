module measured_beams
  !! Beams of scenes whose lines are known: the exact modes of the true beam, each moved by a normal deviate of its own
  !! standard deviation. BEAMWAVE_DRAWS multiplies the number of draws, by hand.
  use bw_measured_state, only: measured_state, state_lines, state_modes, state_of
  use bw_identification, only: identification, identify
  use bw_kinds, only: dp
  use bw_scene, only: scene_type
  use seeded_draws, only: draws_of, normal, start_draws
  use written_scenes, only: scene_from => scene_of
  implicit none (type, external)
  private
  public :: draws_of, find_unknowns, lines_of, normal, scene_from, start_draws, true_modes, uniform

  real(dp), parameter, public :: quantile = 1.959963984540054_dp      !! of 95 %
  character, parameter, public :: nl = new_line('a')
  character(*), parameter, public :: measured = "&record file='a.csv' sample_rate=1000 /&spectrum /&modes before=12 /"//nl

contains

  real(dp) function uniform(low, high)
    real(dp), intent(in) :: low, high
    call random_number(uniform)
    uniform = low + (high - low)*uniform
  end function uniform

  function true_modes(scene, values, count) result(modes)
    !! The first modes of the beam with these values of its unknowns.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: values(:)
    integer, intent(in) :: count
    type(state_modes) :: modes
    type(measured_state) :: state
    integer :: k
    state = state_of(scene, scene%unknowns, lines_of([real(dp) ::], [real(dp) ::]))
    call state%modes_at(values, [(k, k=1, count)], modes)
  end function true_modes

  function lines_of(frequency, relative) result(lines)
    !! Lines that were measured to these relative standard deviations, and have no decay.
    real(dp), intent(in) :: frequency(:), relative(:)
    type(state_lines) :: lines
    integer :: k
    allocate (lines%frequency(size(frequency)))
    do k = 1, size(frequency)
      lines%frequency(k) = frequency(k)*(1 + relative(k)*normal())
    end do
    lines%deviation = relative*frequency
    allocate (lines%decay(size(frequency)), source=0.0_dp)
    lines%decay_deviation = lines%deviation
  end function lines_of

  subroutine find_unknowns(scene, lines, found)
    !! What the lines say of the unknowns of a scene.
    type(scene_type), intent(in) :: scene
    type(state_lines), intent(in) :: lines
    type(identification), intent(out) :: found
    type(measured_state) :: states(1)
    states(1) = state_of(scene, scene%unknowns, lines)
    call identify(states, scene%unknowns, quantile, found)
  end subroutine find_unknowns

end module measured_beams
