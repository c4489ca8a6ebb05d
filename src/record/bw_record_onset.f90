module bw_record_onset
  !! Where the motion of a record begins, if the recorder was started before the blow.
  !!
  !! A window of w samples, 1/128 of the record, behind the first k ≥ 2w samples: all of these are quiet, and the motion begins
  !! between the two, if about the mean of the k samples the root mean square of the window is more than `louder` times theirs
  !! and one digit, and at least half of the window is beyond `beyond` times that. A motion that is smooth over 3w samples cannot
  !! do so: a ramp reaches 2.7 times, a parabola from its vertex 4.4, and a cube 6.8; nor can a line that grows: √(2g) e^(g/128)
  !! times, 8.1 of one that grows by e^g = 10¹⁰ along the record. A single wrong sample fails the second test.
  use bw_kinds, only: dp, i8
  use bw_record_flaws, only: smallest_step
  implicit none (type, external)
  private
  public :: onset

  real(dp), parameter :: louder = 10.0_dp
  real(dp), parameter :: beyond = 3.0_dp
  integer(i8), parameter :: least_window = 16    !! samples
  integer(i8), parameter :: windows = 128        !! in a record

contains

  pure integer(i8) function onset(values) result(first)
    !! Number of the first sample, from 1, that belongs to the motion; 0 where the record does not begin with a quiet part.
    real(dp), intent(in) :: values(:)            !! of one sensor, in the order of their times
    real(dp), allocatable :: away(:)             !! from the first of all, in parts of the largest: an offset takes no digits
    real(dp) :: before(2), window(2), mean, variance, quiet, digit, range
    integer(i8) :: n, w, k
    first = 0
    n = size(values, kind=i8)
    w = max(least_window, n/windows)
    range = maxval(abs(values - values(1)))
    if (n < 3*w .or. .not. range > 0.0_dp) return
    allocate (away(n))
    away = (values - values(1))/range
    digit = smallest_step(values)/range
    before = [sum(away(:2*w)), sum(away(:2*w)**2)]
    window = [sum(away(2*w + 1:3*w)), sum(away(2*w + 1:3*w)**2)]
    do k = 2*w, n - w
      mean = before(1)/k
      variance = max(0.0_dp, before(2)/k - mean**2)
      if (window(2)/w - 2*mean*window(1)/w + mean**2 > louder**2*variance) then   ! first what is cheap
        quiet = sqrt(variance) + digit
        if (sum((away(k + 1:k + w) - mean)**2) > w*(louder*quiet)**2 .and. &
            2*count(abs(away(k + 1:k + w) - mean) > beyond*quiet) >= w) exit
      end if
      if (k == n - w) return
      before = before + [away(k + 1), away(k + 1)**2]
      window = window + [away(k + w + 1) - away(k + 1), away(k + w + 1)**2 - away(k + 1)**2]
    end do
    first = k + findloc(abs(away(k + 1:k + w) - mean) > beyond*quiet, .true., dim=1)
  end function onset

end module bw_record_onset
