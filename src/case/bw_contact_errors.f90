module bw_contact_errors
  !! How far histories through contacts may be from the exact motion of their modes: what the contacts have made of every
  !! error, and the rounding of the sums.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result
  use bw_course, only: course_type, growth_error, held_modes, move
  use bw_course_histories, only: first_sample, last_sample
  use bw_double_double, only: dd, operator(-), operator(*)
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: mode_set
  use bw_scene, only: scene_type
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: estimate_contact_errors

contains

  subroutine estimate_contact_errors(scene, free, grid, result)
    !! `displacement_error` and `velocity_error`, SI, and how the case ends.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: free           !! modes of the beam alone
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result    !! its histories are summed
    real(dp) :: errors(size(scene%response%points), 2)
    real(dp), allocatable :: shapes(:, :), held_shapes(:, :)
    real(dp) :: rounding
    integer :: i
    shapes = free%shapes(scene%response%points)
    if (allocated(result%held)) held_shapes = result%held%shapes(scene%response%points)
    errors = 0.0_dp
    if (allocated(result%courses)) then
      do i = 1, size(result%courses)
        if (result%courses(i)%modes == held_modes) then
          call add_course(result%courses, i, held_shapes, grid, errors)
        else
          call add_course(result%courses, i, shapes, grid, errors)
        end if
      end do
      do i = 2, size(result%courses)
        if (is_blurred(result%courses(i), grid)) errors(:, 2) = max(errors(:, 2), jump_at(free, shapes, held_shapes, i, result))
      end do
    end if
    associate (response => result%response, speed => abs(result%approach_velocity), n => result%response%finite_samples)
      rounding = response%sum_error + growth_error(free, grid%samples*grid%step%hi)
      if (allocated(result%held)) rounding = rounding + growth_error(result%held, grid%samples*grid%step%hi)
      response%displacement_error = errors(:, 1)*(speed*result%units%time%hi) &
        + rounding*largest_magnitude(response%displacement(:n, :))
      if (allocated(response%velocity)) response%velocity_error = errors(:, 2)*speed &
        + rounding*largest_magnitude(response%velocity(:n, :))
    end associate
    result%status = result%ending
  end subroutine estimate_contact_errors

  pure subroutine add_course(courses, i, shapes, grid, errors)
    !! Where one has samples.
    type(course_type), intent(in) :: courses(:)
    integer, intent(in) :: i
    real(dp), intent(in) :: shapes(:, :)          !! of its modes, (modes, points)
    type(time_grid), intent(in) :: grid
    real(dp), intent(inout) :: errors(:, :)       !! of displacements in V l²/h and velocities in V, (points, 2)
    if (first_sample(courses(i), grid) > last_sample(courses, i, grid)) return
    errors = max(errors, matmul(transpose(abs(shapes)), courses(i)%error))
  end subroutine add_course

  pure logical function is_blurred(course, grid)
    !! A sample comes so close to the contact with which the course starts that it may belong to the other side of it.
    type(course_type), intent(in) :: course
    type(time_grid), intent(in) :: grid
    type(dd) :: distance
    distance = course%start - grid%step*anint(course%start%hi/grid%step%hi)
    is_blurred = abs(distance%hi) <= course%start_error
  end function is_blurred

  pure function jump_at(free, shapes, held_shapes, i, result) result(jump)
    !! By how much the velocity jumps where a course starts, (points).
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: shapes(:, :)                   !! (modes, points)
    real(dp), intent(in), optional :: held_shapes(:, :)    !! absent: no contact lasts
    integer, intent(in) :: i
    type(case_result), intent(in) :: result
    real(dp) :: jump(size(shapes, 2)), q(size(shapes, 1)), rate(size(shapes, 1))
    associate (before => result%courses(i - 1), after => result%courses(i))
      q = before%q
      rate = before%rate
      if (before%modes == held_modes) then
        call move(result%held, after%start - before%start, q, rate)
        jump = matmul(rate, held_shapes)
      else
        call move(free, after%start - before%start, q, rate)
        jump = matmul(rate, shapes)
      end if
      if (after%modes == held_modes) then
        jump = abs(matmul(after%rate, held_shapes) - jump)
      else
        jump = abs(matmul(after%rate, shapes) - jump)
      end if
    end associate
  end function jump_at

end module bw_contact_errors
