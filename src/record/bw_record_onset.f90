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
    real(dp) :: before(2), window(2), mean, quiet, loud, digit
    integer(i8) :: n, w, k
    first = 0
    n = size(values, kind=i8)
    w = max(least_window, n/windows)
    if (n < 3*w) return
    digit = smallest_step(values)
    before = sums(1_i8, 2*w)
    window = sums(2*w + 1, 3*w)
    do k = 2*w, n - w
      mean = before(1)/k
      quiet = sqrt(max(0.0_dp, before(2)/k - mean**2)) + digit
      loud = sqrt(max(0.0_dp, window(2)/w - 2*mean*window(1)/w + mean**2))
      if (loud > louder*quiet) then
        if (2*count(abs(values(k + 1:k + w) - values(1) - mean) > beyond*quiet) >= w) exit
      end if
      if (k == n - w) return
      before = before + sums(k + 1, k + 1)
      window = window - sums(k + 1, k + 1) + sums(k + w + 1, k + w + 1)
    end do
    first = k + findloc(abs(values(k + 1:k + w) - values(1) - mean) > beyond*quiet, .true., dim=1)

  contains

    pure function sums(from, to)
      !! Of samples and their squares, less the first sample of all: an offset does not take their digits.
      integer(i8), intent(in) :: from, to
      real(dp) :: sums(2)
      sums = [sum(values(from:to) - values(1)), sum((values(from:to) - values(1))**2)]
    end function sums

  end function onset

end module bw_record_onset
