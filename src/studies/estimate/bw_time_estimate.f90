module bw_time_estimate
  !! The run time of a scene, estimated from counts known beforehand.
  use bw_case_cost, only: case_counts, cases_term, modes_seconds, numbers_term, run_term, seconds_of, shared_terms, term_count
  use bw_case_tolerance, only: plan_case
  use bw_error, only: error_type
  use bw_kinds, only: dp, i8
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_record_search, only: searched_first
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  implicit none (type, external)
  private
  public :: estimated_seconds, record_seconds, scene_counts

  integer, parameter :: most_samples = 50                  !! cases of a sweep that are examined; tolerances of fewer are planned
  integer, parameter :: most_planned = 4
  real(dp), parameter :: golden = 0.6180339887498949_dp    !! its multiples fill 0 … 1 evenly, for any number of them

contains

  real(dp) function estimated_seconds(scene, numbers, planned, monitor) result(seconds)
    !! Return the wall time of all cases by one process on a core of its own, s.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: numbers             !! of a case, in the result
    integer, intent(in) :: planned                 !! as in `scene_counts`
    class(monitor_type), intent(inout), target :: monitor   !! the time is invalid if it asks to stop
    seconds = seconds_of(scene_counts(scene, numbers, planned, monitor))
  end function estimated_seconds

  function scene_counts(scene, numbers, planned, monitor) result(counts)
    !! Count each term of the cost model: in the first case of a sweep, and in others spread over it, each following its
    !! neighbour, with which it may share modes.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: numbers
    integer, intent(in) :: planned                 !! modes that the tolerance of a single case needs
    class(monitor_type), intent(inout), target :: monitor
    real(dp) :: counts(term_count), others(term_count)
    type(scene_type) :: one
    integer(i8) :: others_left
    integer :: samples, i
    others = 0.0_dp
    others_left = case_count(scene) - 1
    samples = int(min(others_left, int(merge(most_planned, most_samples, by_tolerance(scene%modes)), i8)))
    call add(1_i8, others)
    counts = others
    others = 0.0_dp
    do i = 1, samples
      if (monitor%stop_requested()) exit
      call add(2 + int(modulo(i*golden, 1.0_dp)*real(others_left, dp), i8), others)
    end do
    counts = counts + others*(real(others_left, dp)/max(1, samples))
    counts([numbers_term, cases_term, run_term]) = real([(others_left + 1)*numbers, others_left + 1, 1_i8], dp)
  contains
    subroutine add(index, total)
      !! Of a case.
      integer(i8), intent(in) :: index
      real(dp), intent(inout) :: total(:)
      type(error_type), allocatable :: error
      integer :: tolerated
      tolerated = planned
      if (index > 1) call case_scene(scene, index - 1, one, error)
      call case_scene(scene, index, one, error)
      if (.not. allocated(error) .and. others_left > 0) call plan_case(one, monitor, tolerated, error)
      if (allocated(error)) return
      total = total + merge(0.0_dp, case_counts(one, tolerated), index > 1 .and. shared_terms(one))
    end subroutine add
  end function scene_counts

  pure real(dp) function record_seconds(scene, layout) result(seconds)
    !! Return the time to find the lines of all cases of a record on one core, and to fit unknowns. Calibrated on 48 records
    !! of 1 to 8 lines in 600 to 300 000 numbers, on larger ones of 20 lines, and on fits of beams of 1 to 10 pieces.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    real(dp), parameter :: of_search = 0.1_dp, of_number = 3.0e-6_dp, of_followed = 4.0e-7_dp, of_solution = 1.0e-4_dp
    integer, parameter :: solutions = 350          ! mode solutions per unknown
    real(dp) :: numbers, searched                  ! lines of the first part are followed through the others
    numbers = real(layout%points, dp)*layout%record%longest
    searched = min(numbers, 2.0_dp*searched_first)
    seconds = max(1, layout%cases)*(of_search + of_number*searched + of_followed*(numbers - searched))
    if (size(scene%unknowns) > 0) seconds = seconds + size(scene%unknowns)*solutions*(of_solution + modes_seconds(scene))
  end function record_seconds

end module bw_time_estimate
