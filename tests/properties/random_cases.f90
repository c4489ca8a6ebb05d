module random_cases
  !! Random scenes, run one after the other; the seed is printed once for each test.
  use, intrinsic :: iso_fortran_env, only: output_unit
  use bw_case_result, only: case_result
  use bw_kinds, only: dp
  use bw_monitor, only: silent_monitor
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: layout_of, result_layout
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stopwatch
  use random_streams, only: random_stream, stream_of_environment
  implicit none (type, external)
  private
  public :: announced_stream, run_scene

  integer, parameter, public :: rounds = 1000

contains

  type(random_stream) function announced_stream(property) result(stream)
    !! The stream of the environment's seed, or of the default one.
    character(*), intent(in) :: property
    stream = stream_of_environment()
    write (output_unit, '(2x,i0,5a)') rounds, ' random scenes: ', property, ' (', stream%seed_text(), ')'
  end function announced_stream

  subroutine run_scene(scene, outcome, velocity_factor)
    !! Compute a scene, its approach velocity multiplied.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(out) :: outcome
    real(dp), intent(in), optional :: velocity_factor
    type(scene_type) :: one
    type(result_layout) :: layout
    type(case_cache) :: cache
    type(stopwatch) :: watch
    type(silent_monitor) :: monitor
    logical :: whole
    one = scene
    if (present(velocity_factor)) one%impact%approach_velocity = velocity_factor*one%impact%approach_velocity
    layout = layout_of(one)
    call run_case(one, layout, watch, monitor, cache, outcome, whole)
  end subroutine run_scene

end module random_cases
