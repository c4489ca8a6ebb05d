module bw_level_beside
  !! The level of coloured noise right beside a line.
  !!
  !! The level that lines are searched by is smooth over tens of ordinates. Behind a filter it is wrong between the filter's zeros
  !! and at the edges of its band, where it changes within a few, and what stands above it need not stand above its neighbours.
  use bw_damped_line, only: damped_line
  use bw_kinds, only: dp
  use bw_ordinates, only: ordinates_type
  use bw_samples, only: samples_type, span_of
  implicit none (type, external)
  private
  public :: stands_out_beside

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: widths(3) = [4, 8, 16]  !! bins on one side of the line
  real(dp), parameter :: own = 1.5_dp            !! bins to either side that are the line's, beside its half width

contains

  pure logical function stands_out_beside(samples, ordinates, line, pays, threshold) result(stands)
    !! Whether a line still pays enough where the noise has the highest level that ordinates on one of its sides have. A drift describes
    !! more of it than a line does.
    type(samples_type), intent(in) :: samples
    type(ordinates_type), intent(in) :: ordinates  !! of what is left without the line
    type(damped_line), intent(in) :: line
    real(dp), intent(in) :: pays                   !! over the smooth level
    real(dp), intent(in) :: threshold
    real(dp) :: bin, level
    integer :: middle, away, width, i
    bin = ordinates%length/span_of(samples)
    middle = nint(line%frequency*ordinates%length)
    away = nint(bin*(own + abs(line%decay)*span_of(samples)/(2*pi)))
    level = 1
    do i = 1, size(widths)
      width = nint(bin*widths(i))
      level = max(level, mean(middle - away - width, middle - away), mean(middle + away, middle + away + width))
    end do
    stands = pays > level*threshold*(1 + 1/ordinates%shape)*max(line%powers, 1)  ! few ordinates do not tell their mean well

  contains

    pure real(dp) function mean(first, last)
      !! Of ordinates, over that of noise; 0 where they reach out of the spectrum.
      integer, intent(in) :: first, last
      mean = 0
      if (first < 0 .or. last > ubound(ordinates%total, 1)) return
      mean = sum(ordinates%total(first:last))/((last - first + 1)*ordinates%shape)
    end function mean

  end function stands_out_beside

end module bw_level_beside
