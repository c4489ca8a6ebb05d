module bw_course_histories
  !! Histories of a motion in several courses, each summed from its own state at its first sample. A sample at exactly
  !! the time of an event belongs to what comes after it.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result
  use bw_course, only: course_type, held_modes, leaves_range, loaded_modes, move
  use bw_double_double, only: dd, operator(-), operator(*)
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, part_monitor
  use bw_response, only: add_motion, finish_histories, response_type, start_histories
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: sum_courses, add_course, first_sample, take, last_sample

  real(dp), parameter :: same_instant = epsilon(1.0_dp)   !! of the time: it is given in binary64

contains

  subroutine sum_courses(free, loaded, points, grid, monitor, result)
    !! All courses of a case, in order; leaves early if the monitor asks for it.
    class(mode_set), intent(in), optional :: free, loaded    !! modes of the beam alone, and of beam and mass
    real(dp), intent(in) :: points(:)             !! ξ, (points)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result    !! its histories are started
    integer :: i, last
    result%response%finite_samples = samples_before(result%known_until, grid)
    do i = 1, size(result%courses)
      last = min(last_sample(result%courses, i, grid), result%response%finite_samples)
      select case (result%courses(i)%modes)
      case (loaded_modes); call add_course(result%courses(i), loaded, last, points, grid, monitor, result)
      case (held_modes); call add_course(result%courses(i), result%held, last, points, grid, monitor, result)
      case default; call add_course(result%courses(i), free, last, points, grid, monitor, result)
      end select
      if (monitor%stop_requested()) return
    end do
    call finish_histories(1.0_dp, result%response)
  end subroutine sum_courses

  pure integer function samples_before(time, grid) result(samples)
    !! How many of the samples come before a time.
    real(dp), intent(in) :: time                  !! l²/h
    type(time_grid), intent(in) :: grid
    samples = grid%samples
    if (time >= samples*grid%step%hi) return
    samples = int(max(0.0_dp, time)/grid%step%hi) + 1
    if ((samples - 1)*grid%step%hi >= time) samples = samples - 1
  end function samples_before

  pure integer function last_sample(courses, i, grid) result(last)
    !! Of a course, from 1: before the first of the next.
    type(course_type), intent(in) :: courses(:)
    integer, intent(in) :: i
    type(time_grid), intent(in) :: grid
    last = grid%samples
    if (i < size(courses)) last = first_sample(courses(i + 1), grid) - 1
  end function last_sample

  subroutine add_course(course, modes, last, points, grid, monitor, result)
    !! From the first sample of a course to its last.
    type(course_type), intent(in) :: course
    class(mode_set), intent(in) :: modes          !! that move in it
    integer, intent(in) :: last                   !! sample, from 1
    real(dp), intent(in) :: points(:)             !! ξ, (points)
    type(time_grid), intent(in) :: grid           !! of the whole history
    class(monitor_type), intent(inout), target :: monitor
    type(case_result), intent(inout) :: result    !! its histories are started
    type(response_type) :: part
    type(part_monitor) :: share
    real(dp) :: q(modes%count), rate(modes%count), unit
    integer :: first
    first = first_sample(course, grid)
    if (first > last .or. result%response%failing_mode > 0) return
    q = course%q
    rate = course%rate
    if (leaves_range(modes, grid%step*real(first - 1, dp) - course%start)) then
      result%response%failing_mode = 1
      result%response%finite_samples = first - 1
      return
    end if
    call move(modes, grid%step*real(first - 1, dp) - course%start, q, rate)
    share = part_monitor(monitor, real(first - 1, dp)/grid%samples, real(last - first + 1, dp)/grid%samples)
    call start_histories(time_grid(last - first + 1, grid%step), size(points), allocated(result%response%velocity), part)
    unit = result%approach_velocity*result%units%time%hi
    call add_motion(modes, rate*unit, points, time_grid(last - first + 1, grid%step), result%units%time%hi, share, part, &
                    displaced=q*unit)
    result%response%sum_error = max(result%response%sum_error, part%sum_error)
    call finish_histories(result%units%time%hi, part)
    call take(part, first, last, result%response)
  end subroutine add_course

  pure integer function first_sample(course, grid)
    !! The first sample, from 1, at or after the start.
    type(course_type), intent(in) :: course
    type(time_grid), intent(in) :: grid
    type(dd) :: early
    first_sample = max(1, min(int(course%start%hi/grid%step%hi), grid%samples))
    do while (first_sample <= grid%samples)
      early = course%start - grid%step*real(first_sample - 1, dp)
      if (early%hi <= same_instant*course%start%hi) exit
      first_sample = first_sample + 1
    end do
  end function first_sample

  pure subroutine take(part, first, last, whole)
    !! Histories of a part of the samples into those of all.
    type(response_type), intent(in) :: part
    integer, intent(in) :: first, last
    type(response_type), intent(inout) :: whole
    whole%displacement(first:last, :) = part%displacement
    if (allocated(whole%velocity)) whole%velocity(first:last, :) = part%velocity
    if (part%failing_mode == 0) return
    whole%failing_mode = part%failing_mode
    whole%finite_samples = first - 1 + part%finite_samples
  end subroutine take

end module bw_course_histories
