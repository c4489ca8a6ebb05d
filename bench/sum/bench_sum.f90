module bench_sum
  !! What the commands of bench/sum call, to time it in one process with its rival. Without dimensions: lengths in l, times in l²/h.
  use, intrinsic :: iso_c_binding
  use bw_closed_form_source, only: closed_form_source, source_in_closed_form
  use bw_double_double, only: dd, to_dd, operator(*)
  use bw_kinds, only: dp
  use bw_modal_sum, only: add_stable_modes
  use bw_monitor, only: silent_monitor
  use bw_nonuniform_sum, only: nonuniform_sum, points_at_once
  use bw_response, only: response_type, sampling_type, start_histories
  use bw_streamed_modes, only: add_modes_of_source
  use bw_sum_choice, only: chosen_sum, sum_choice
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private

  integer, parameter :: part = 256               ! modes at a time, as in a run
  real(dp), parameter :: points(2) = [0.5_dp, 1.0_dp]

contains

  subroutine whole_job(n, samples, gamma, duration, displacement) bind(c, name='bench_whole_job')
    !! Roots, shapes at the midpoint and the tip, and the sum of n modes of the continuum, as a run with a tolerance does it.
    integer(c_int), value :: n, samples
    real(c_double), value :: gamma, duration
    real(c_double), intent(out) :: displacement(samples, 2)
    type(nonuniform_sum) :: sum
    type(response_type) :: response
    type(time_grid) :: grid
    type(silent_monitor) :: monitor
    grid = time_grid_of(duration, samples, to_dd(1.0_dp))
    call start_histories(sampling_type(points, grid), response)
    call add_modes_of_source(source_in_closed_form(gamma), gamma, 1, n, monitor, response, sum)
    displacement = response%displacement
  end subroutine whole_job

  subroutine terms(n, gamma, duration, beta, rate, shapes) bind(c, name='bench_terms')
    !! The modes alone.
    integer(c_int), value :: n
    real(c_double), value :: gamma, duration
    real(c_double), intent(out) :: beta(2, n)              !! high and low parts
    real(c_double), intent(out) :: rate(n), shapes(n, 2)
    type(closed_form_source) :: source
    type(dd) :: values(part)
    real(dp) :: mass(part)
    integer :: i, k, e
    source = source_in_closed_form(gamma)
    do k = 1, n, part
      e = min(k + part - 1, n)
      call source%terms([(i, i=k, e)], points, duration, values(:e - k + 1), rate(k:e), shapes(k:e, :), &
                        mass(:e - k + 1))
      beta(1, k:e) = values(:e - k + 1)%hi
      beta(2, k:e) = values(:e - k + 1)%lo
    end do
    rate = gamma*rate
  end subroutine terms

  subroutine choose(n, samples, histories, transform, width, half) bind(c, name='bench_choice')
    !! What the cost model chooses, and the transform that it would choose in any case.
    integer(c_int), value :: n, samples, histories
    integer(c_int), intent(out) :: transform               !! 1: it is chosen
    integer(c_int), intent(out) :: width, half
    type(sum_choice) :: choice
    choice = chosen_sum(n, samples, histories)
    transform = merge(1, 0, choice%transform)
    choice = chosen_sum(n, samples, histories, must_transform=.true.)
    width = choice%width
    half = choice%half
  end subroutine choose

  subroutine by_transform(n, samples, places, beta, rate, shapes, duration, width, half, displacement) &
    bind(c, name='bench_by_transform')
    !! With a given kernel and grid.
    integer(c_int), value :: n, samples, places
    real(c_double), intent(in) :: beta(2, n), rate(n), shapes(n, places)
    real(c_double), value :: duration
    integer(c_int), value :: width, half
    real(c_double), intent(out) :: displacement(samples, places)
    type(nonuniform_sum) :: sum
    type(dd) :: values(part)
    integer :: e, first, group, k, last
    displacement = 0.0_dp
    group = points_at_once(half, samples, places, kinds=1)
    do first = 1, places, group
      last = min(first + group - 1, places)
      call sum%open(time_grid_of(duration, samples, to_dd(1.0_dp)), width, half, last - first + 1, with_velocity=.false., &
                    moved=.false.)
      do k = 1, n, part
        e = min(k + part - 1, n)
        values(:e - k + 1)%hi = beta(1, k:e)
        values(:e - k + 1)%lo = beta(2, k:e)
        call sum%add(values(:e - k + 1), rate(k:e), shapes(k:e, first:last))
      end do
      call sum%close(displacement(:, first:last))
    end do
  end subroutine by_transform

  subroutine by_products(n, samples, places, beta, rate, shapes, duration, displacement) bind(c, name='bench_by_products')
    integer(c_int), value :: n, samples, places
    real(c_double), intent(in) :: beta(2, n), rate(n), shapes(n, places)
    real(c_double), value :: duration
    real(c_double), intent(out) :: displacement(samples, places)
    type(silent_monitor) :: monitor
    type(dd) :: squares(n)
    real(dp) :: rest(n)
    squares%hi = beta(1, :)
    squares%lo = beta(2, :)
    squares = squares*squares
    rest = 0.0_dp
    displacement = 0.0_dp
    call add_stable_modes(squares, rest, rate, shapes, time_grid_of(duration, samples, to_dd(1.0_dp)), monitor, displacement)
  end subroutine by_products

end module bench_sum
