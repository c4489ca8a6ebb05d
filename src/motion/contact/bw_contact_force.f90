module bw_contact_force
  !! The contact force, a polynomial in each step: its maximum, its values, and the zero of it or of the indentation
  !! rate in a step. Units of bw_segment.
  use bw_force_response, only: force_degree
  use bw_force_step, only: force_in_step, node_places, polynomial_of
  use bw_kinds, only: dp
  use bw_segment, only: load_type
  implicit none (type, external)
  private
  public :: end_in_step, find_largest, first_zero, force_at

contains

  pure real(dp) function first_zero(values) result(x)
    !! Return the zero of a polynomial that is positive at the start of a step, as a fraction of the step, by bisection.
    real(dp), intent(in) :: values(0:)            !! at the Chebyshev points
    real(dp) :: above, below, value
    integer :: i, j
    i = findloc(values(1:) <= 0.0_dp, .true., dim=1)
    above = node_places(i - 1)
    below = node_places(i)
    do j = 1, 60
      x = 0.5_dp*(above + below)
      call force_in_step(polynomial_of(values), x, value)
      if (value > 0.0_dp) then
        above = x
      else
        below = x
      end if
    end do
  end function first_zero

  pure real(dp) function end_in_step(length, indentation, force) result(time)
    !! Return when indentation or force first vanishes in a short step, by linear interpolation.
    real(dp), intent(in) :: length, indentation(:), force(0:)
    integer :: i
    i = findloc(indentation <= 0.0_dp .or. force(1:) <= 0.0_dp, .true., dim=1)
    time = node_places(i - 1)
    if (i > 1 .and. indentation(i) <= 0.0_dp) &
      time = time + (node_places(i) - node_places(i - 1))*indentation(i - 1)/(indentation(i - 1) - indentation(i))
    time = time*length
  end function end_in_step

  pure subroutine find_largest(load, force, time)
    !! Find the largest force of a contact, and its time since the start.
    type(load_type), intent(in) :: load
    real(dp), intent(out) :: force, time
    integer, parameter :: parts = 40, refinements = 50
    real(dp) :: coefficients(0:force_degree), left, right, x(2), value(2)
    integer :: at(2), i, j
    force = 0.0_dp
    time = 0.0_dp
    if (size(load%length) == 0) return
    at = maxloc(load%force)
    do i = max(1, at(2) - 1), min(size(load%length), at(2) + 1)
      coefficients = polynomial_of(load%force(:, i))
      left = 0.0_dp
      call force_in_step(coefficients, left, value(1))
      do j = 1, parts
        call force_in_step(coefficients, real(j, dp)/parts, value(2))
        if (value(2) > value(1)) left = real(j, dp)/parts
        value(1) = max(value(1), value(2))
      end do
      right = min(1.0_dp, left + 1.0_dp/parts)
      left = max(0.0_dp, left - 1.0_dp/parts)
      do j = 1, refinements
        x = [left + (right - left)/3.0_dp, right - (right - left)/3.0_dp]
        call force_in_step(coefficients, x(1), value(1))
        call force_in_step(coefficients, x(2), value(2))
        if (value(1) < value(2)) then
          left = x(1)
        else
          right = x(2)
        end if
      end do
      call force_in_step(coefficients, left, value(1))
      if (value(1) <= force) cycle
      force = value(1)
      time = sum(load%length(:i - 1)) + left*load%length(i)
    end do
  end subroutine find_largest

  pure function force_at(load, times) result(force)
    !! Return the force of a contact at times since its start, up to its end.
    type(load_type), intent(in) :: load
    real(dp), intent(in) :: times(:)              !! ascending, l²/h
    real(dp) :: force(size(times)), start
    integer :: i, step
    force = 0.0_dp
    start = 0.0_dp
    step = 1
    do i = 1, size(times)
      do while (step < size(load%length))
        if (times(i) <= start + load%length(step)) exit
        start = start + load%length(step)
        step = step + 1
      end do
      call force_in_step(polynomial_of(load%force(:, step)), min(1.0_dp, (times(i) - start)/load%length(step)), force(i))
      force(i) = max(0.0_dp, force(i))
    end do
  end function force_at

end module bw_contact_force
