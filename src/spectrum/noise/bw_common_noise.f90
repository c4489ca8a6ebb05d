module bw_common_noise
  !! Noise that sensors share, and sums of sensors whose noise is independent.
  !!
  !! Samples y = Mx of sensors whose noise has the covariance MMᵀ hold the same lines as x = M⁻¹y, with other amplitudes, and the
  !! noise of x is independent: all that is said of lines at sensors of independent noise holds for x. M comes from what lines
  !! leave of the transforms, over the level of each sensor's noise: an estimate of their correlations R that few large ordinates,
  !! as of lines that nobody has found, do not move (Huber, 1964; Maronna, 1976). The x are its principal components. Their levels
  !! are found anew, by frequency, so that it is the directions alone that R has to tell.
  use bw_kinds, only: dp
  use bw_lapack, only: dgemm, dsyev
  use bw_samples, only: keep_sensors, samples_type
  implicit none (type, external)
  private
  public :: find_mixture, join, parts_of, separate, separation_of

  integer, parameter :: rounds = 10
  integer, parameter :: rows = 1024            !! samples that are separated at once
  real(dp), parameter :: by_chance = 3.09_dp   !! standard deviations of a normal number: independent noise makes it once in 1000
  real(dp), parameter :: worth = 0.01_dp       !! squared correlations of a sensor with all others; less changes nothing
  real(dp), parameter :: least = 1.0e-3_dp     !! eigenvalue of R, whose trace is S: noise is the same but for a thirtieth
  real(dp), parameter :: faint = 0.1_dp        !! deviations of the sensors' noise, that lines and all have in such a mixture

  type, public :: mixture_type
    !! Not allocated: the sensors' noise is independent.
    real(dp), allocatable :: mixed(:, :)       !! M, (S, x)
    real(dp), allocatable :: separating(:, :)  !! its inverse, (x, S)
  end type mixture_type

contains

  subroutine find_mixture(samples, seen, deviation, mixture)
    !! Find M where sensors share noise beyond doubt. A mixture in which neither noise nor lines are left, as the difference of two
    !! copies that were rounded, is left out: there are fewer x than sensors.
    type(samples_type), intent(in) :: samples
    complex(dp), intent(in) :: seen(:, :)      !! independent ordinates over the root of the noise's level, (ordinates, S)
    real(dp), intent(in) :: deviation(:)       !! of each sensor's noise, (S)
    type(mixture_type), intent(out) :: mixture
    real(dp), dimension(size(deviation), size(deviation)) :: correlation, vectors
    real(dp) :: values(size(deviation)), squares, pairs, chance
    logical :: tells(size(deviation))
    integer, allocatable :: kept(:)
    integer :: s, sensors
    sensors = size(deviation)
    if (sensors == 1 .or. size(seen, 1) < 2) return
    correlation = correlations(seen)
    squares = sum(correlation**2) - sensors
    pairs = 0.5_dp*sensors*(sensors - 1)
    chance = size(seen, 1)*squares*sensors/(sensors + 1.0_dp)  ! χ² of as many degrees of freedom as there are pairs
    if (squares < worth*sensors) return
    if ((chance/pairs)**(1/3.0_dp) < 1 - 2/(9*pairs) + by_chance*sqrt(2/(9*pairs))) return
    call decompose(correlation, values, vectors)
    do s = 1, sensors
      tells(s) = values(s) > least
      if (.not. tells(s)) tells(s) = deviation_of(samples, vectors(:, s)/deviation) > faint
    end do
    kept = pack([(s, s=1, sensors)], tells)
    mixture%mixed = spread(deviation, 2, size(kept))*vectors(:, kept)*spread(sqrt(values(kept)), 1, sensors)
    mixture%separating = transpose(vectors(:, kept)/(spread(deviation, 2, size(kept))*spread(sqrt(values(kept)), 1, sensors)))
  end subroutine find_mixture

  pure real(dp) function deviation_of(samples, factor) result(deviation)
    !! The standard deviation of a sum of all sensors, each times a factor.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: factor(:)
    real(dp) :: values(samples%count)
    integer :: s
    values = 0
    do s = 1, size(factor)
      values = values + factor(s)*samples%value(:samples%count, s)
    end do
    deviation = norm2(values - sum(values)/size(values))/sqrt(real(size(values), dp))
  end function deviation_of

  function correlations(seen) result(correlation)
    !! Those of the real parts, and of the imaginary parts, with 1 on the diagonal. An ordinate counts the less, the further it is
    !! beyond those of such noise.
    complex(dp), intent(in) :: seen(:, :)
    real(dp), dimension(size(seen, 2), size(seen, 2)) :: correlation, vectors
    real(dp), dimension(2*size(seen, 1), size(seen, 2)) :: parts, weighted
    real(dp) :: values(size(seen, 2)), weight(size(seen, 1)), scale(size(seen, 2)), square
    integer :: round, s, n, sensors
    n = size(seen, 1)
    sensors = size(seen, 2)
    parts(:n, :) = real(seen, dp)
    parts(n + 1:, :) = aimag(seen)
    weight = 1
    do round = 1, rounds
      do s = 1, sensors
        weighted(:n, s) = weight*parts(:n, s)
        weighted(n + 1:, s) = weight*parts(n + 1:, s)
      end do
      call dgemm('T', 'N', sensors, sensors, 2*n, 1.0_dp/n, parts, 2*n, weighted, 2*n, 0.0_dp, correlation, sensors)
      scale = [(sqrt(max(correlation(s, s), tiny(1.0_dp))), s=1, sensors)]
      do s = 1, sensors
        parts(:, s) = parts(:, s)/scale(s)
        correlation(:, s) = correlation(:, s)/(scale*scale(s))
        correlation(s, s) = 1
      end do
      if (round == rounds) exit
      call decompose(correlation, values, vectors)
      do s = 1, sensors
        vectors(:, s) = vectors(:, s)/sqrt(values(s))
      end do
      call dgemm('N', 'N', 2*n, sensors, sensors, 1.0_dp, parts, 2*n, vectors, sensors, 0.0_dp, weighted, 2*n)
      do s = 1, n
        square = sum(weighted(s, :)**2) + sum(weighted(n + s, :)**2)
        weight(s) = 1/max(square/sensors, 1.0_dp)
      end do
    end do
  end function correlations

  subroutine decompose(matrix, values, vectors)
    !! Eigenvalues and eigenvectors of correlations.
    real(dp), intent(in) :: matrix(:, :)
    real(dp), intent(out) :: values(:), vectors(:, :)
    real(dp) :: work(64*size(values))
    integer :: info
    vectors = matrix
    call dsyev('V', 'U', size(values), vectors, size(values), values, work, size(work), info)
    if (info /= 0) error stop 'the eigenvalues of correlations did not converge'
    values = max(values, least)
  end subroutine decompose

  function separation_of(correlation) result(separating)
    !! What turns numbers of these correlations into independent ones of the same variance.
    real(dp), intent(in) :: correlation(:, :)
    real(dp), dimension(size(correlation, 1), size(correlation, 2)) :: separating, vectors
    real(dp) :: values(size(correlation, 1))
    integer :: s
    call decompose(correlation, values, vectors)
    do s = 1, size(values)
      separating(:, s) = vectors(:, s)/sqrt(values(s))
    end do
    separating = matmul(separating, transpose(vectors))
  end function separation_of

  subroutine separate(mixture, samples)
    !! Turn samples y into x, in their memory.
    type(mixture_type), intent(in) :: mixture
    type(samples_type), intent(inout) :: samples
    integer :: s
    call sum_up(mixture%separating, samples)
    if (size(mixture%separating, 1) < size(samples%value, 2)) &
      & call keep_sensors([(s, s=1, size(mixture%separating, 1))], samples)
  end subroutine separate

  subroutine join(mixture, samples)
    !! Turn samples x, of which there are as many as sensors, into y, in their memory.
    type(mixture_type), intent(in) :: mixture
    type(samples_type), intent(inout) :: samples
    call sum_up(mixture%mixed, samples)
  end subroutine join

  subroutine sum_up(factor, samples)
    !! Replace the samples of the first sensors by sums of those of all sensors.
    real(dp), intent(in) :: factor(:, :)       !! (sums, S)
    type(samples_type), intent(inout) :: samples
    real(dp) :: part(rows, size(samples%value, 2))
    integer :: first, n
    do first = 1, samples%count, rows
      n = min(rows, samples%count - first + 1)
      part(:n, :) = samples%value(first:first + n - 1, :)
      call dgemm('N', 'T', n, size(factor, 1), size(part, 2), 1.0_dp, part, rows, factor, size(factor, 1), 0.0_dp, &
        & samples%value(first, 1), size(samples%value, 1))
    end do
  end subroutine sum_up

  pure function parts_of(mixture, s, independent) result(parts)
    !! How much of each x is in sensor s, (x).
    type(mixture_type), intent(in) :: mixture
    integer, intent(in) :: s
    integer, intent(in) :: independent         !! how many x there are
    real(dp) :: parts(independent)
    if (allocated(mixture%mixed)) then
      parts = mixture%mixed(s, :)
    else
      parts = 0
      parts(s) = 1
    end if
  end function parts_of

end module bw_common_noise
