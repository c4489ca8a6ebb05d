module bw_time_grid
  !! The times of a history, t_j = j·duration/samples, j = 0 … samples − 1.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, to_dd, operator(*), operator(-), operator(/)
  implicit none (type, external)
  private
  public :: first_sample, sample_times, time_grid_of

  type, public :: time_grid
    integer :: samples = 0
    type(dd) :: step         !! duration/samples in the beam's unit of time l²/h
  end type time_grid

contains

  pure type(time_grid) function time_grid_of(duration, samples, unit) result(grid)
    !! Return the time grid of a history, with its step in extended precision.
    real(dp), intent(in) :: duration    !! s, > 0
    integer, intent(in) :: samples      !! ≥ 1
    type(dd), intent(in) :: unit        !! l²/h, s
    grid%samples = samples
    grid%step = to_dd(duration)/to_dd(real(samples, dp))/unit
  end function time_grid_of

  pure integer function first_sample(time, grid)
    !! Return the first sample, from 1, at or after a time: a sample exactly at an event belongs to what comes after it.
    !! One more than the last if the time is beyond that.
    type(dd), intent(in) :: time        !! in the grid's unit, ≥ 0
    type(time_grid), intent(in) :: grid
    real(dp), parameter :: same_instant = epsilon(1.0_dp)   ! relative, as times are given in binary64
    type(dd) :: early
    first_sample = max(1, min(int(time%hi/grid%step%hi), grid%samples))
    do while (first_sample <= grid%samples)
      early = time - grid%step*real(first_sample - 1, dp)
      if (early%hi <= same_instant*time%hi) exit
      first_sample = first_sample + 1
    end do
  end function first_sample

  pure function sample_times(duration, samples) result(times)
    !! Return the times of the samples, s, (samples).
    real(dp), intent(in) :: duration
    integer, intent(in) :: samples
    real(dp) :: times(samples)
    type(dd) :: step, time
    integer :: j
    step = to_dd(duration)/to_dd(real(samples, dp))
    do j = 1, samples
      time = step*real(j - 1, dp)       ! j·T/N rounded once
      times(j) = time%hi
    end do
  end function sample_times

end module bw_time_grid
