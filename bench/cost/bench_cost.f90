program bench_cost
  !! Print, of each scene file, what `check` says of its seconds, and how often there is each term of the cost model.
  use bw_case_cost, only: seconds_of, term_count
  use bw_case_tolerance, only: fix_tolerance
  use bw_error, only: error_type
  use bw_kinds, only: dp
  use bw_monitor, only: silent_monitor
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene
  use bw_scene_summary, only: case_numbers
  use bw_time_estimate, only: scene_counts
  implicit none (type, external)
  type(scene_type) :: scene
  type(error_type), allocatable :: error
  type(silent_monitor) :: monitor
  real(dp) :: counts(term_count)
  character(1000) :: path
  integer :: i, planned
  do i = 1, command_argument_count()
    call get_command_argument(i, path)
    call read_scene(trim(path), scene, error)
    if (.not. allocated(error)) call fix_tolerance(scene, monitor, planned, error)
    if (allocated(error)) cycle
    counts = scene_counts(scene, case_numbers(scene, layout_of(scene)), planned, monitor)
    print '(a, *(1x, es12.5))', trim(path), seconds_of(counts), counts
  end do
end program bench_cost
