module bw_case_peak
  !! The peak displacement to which a tolerance refers, estimated with few modes before histories are summed.
  use bw_case_modes, only: first_modes
  use bw_case_result, only: case_motion
  use bw_double_double, only: operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_mode_set, only: configuration_type, first_numbers
  use bw_monitor, only: monitor_type, part_monitor
  use bw_projection, only: project, projection_type
  use bw_response, only: response_type, sampling_type, start_histories
  use bw_scene, only: scene_type
  use bw_segment, only: segment_type
  use bw_set_sum, only: add_motion
  use bw_streamed_modes, only: add_modes_of_source
  use bw_time_grid, only: time_grid
  use bw_timeline, only: configurations_of, later_steps, number_of, time_of
  implicit none (type, external)
  private
  public :: peak_after_changes, previewed_peak

contains

  real(dp) function peak_after_changes(scene, motion, segment, grid, samples, monitor) result(peak)
    !! Return a lower estimate of the largest displacement after changes, V l²/h.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(segment_type), intent(in) :: segment    !! before changes
    type(time_grid), intent(in) :: grid          !! of the record
    integer, intent(in) :: samples               !! of the first segment, fewer than in the record
    class(monitor_type), intent(inout), target :: monitor    !! the peak is invalid if it requests a stop
    real(dp), parameter :: sure = 0.5_dp         ! of the peak with few modes
    type(projection_type), allocatable :: projection
    type(configuration_type) :: few
    type(segment_type) :: next
    integer :: i
    peak = 0.0_dp
    associate (steps => later_steps(scene), configuration => motion%modes%configuration)
      do i = 1, size(steps)
        next = segment_type(number_of(configurations_of(scene), steps(i)%carried), time_of(steps(i), motion%units))
        associate (after => configuration(next%configuration)%source)
          call after%find(first_numbers(min(first_modes, after%highest)), few%set, grid%samples*grid%step%hi)
        end associate
        if (allocated(projection)) deallocate (projection)
        allocate (projection)
        call project(segment, configuration(segment%configuration), next%start, grid%samples*grid%step%hi, 0, few%set, &
                     projection, monitor)
        if (monitor%stop_requested()) return
        next%q = projection%q_after
        next%rate = projection%rate_after
        peak = max(peak, sure*previewed_peak(scene, few, next, few%set%count, time_grid(grid%samples - samples, grid%step), &
                                             motion%units%time%hi, monitor))
      end do
    end associate
  end function peak_after_changes

  real(dp) function previewed_peak(scene, configuration, segment, count, grid, unit_time, monitor) result(peak)
    !! Return the largest displacement of the first modes at some samples, V l²/h; at all samples if a mode grows, whose
    !! peak is at the end.
    type(scene_type), intent(in) :: scene
    type(configuration_type), intent(in) :: configuration
    type(segment_type), intent(in) :: segment
    integer, intent(in) :: count                 !! modes summed
    type(time_grid), intent(in) :: grid          !! of the segment
    real(dp), intent(in) :: unit_time            !! s
    class(monitor_type), intent(inout), target :: monitor
    integer, parameter :: previewed = 256        ! samples that show the peak well enough for a plan
    type(response_type) :: response
    type(part_monitor) :: part
    integer :: stride
    stride = (grid%samples - 1)/previewed + 1
    if (any(configuration%set%beta_squared%hi <= 0.0_dp)) stride = 1
    part = part_monitor(monitor, share=0.0_dp)
    call start_histories(sampling_type(scene%response%points, time_grid((grid%samples - 1)/stride + 1, &
                                       grid%step*real(stride, dp)), unit_time), response)
    if (allocated(segment%rate)) then
      call add_motion(configuration%set, segment%rate, part, response, displaced=segment%q)
    else
      call add_modes_of_source(configuration%source, segment%force, 1, count, part, response)
    end if
    peak = maxval(abs(response%displacement(:response%finite_samples, :)))
  end function previewed_peak

end module bw_case_peak
