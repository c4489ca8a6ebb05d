module bw_sensor_factors
  !! The real factor by which each sensor's modal constants are best those of the model: 1 where sensor and hammer are calibrated,
  !! and negative where one of them is reversed.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: amplitude_weights, best_factors

  real(dp), parameter, public :: sensor_error = 0.01_dp
    !! chosen: of the largest amplitude: sensors are seldom calibrated or placed better

contains

  pure function amplitude_weights(amplitude, deviation, error) result(weight)
    !! Inverse variances of the amplitudes of one line, (sensors).
    complex(dp), intent(in) :: amplitude(:)
    real(dp), intent(in) :: deviation(:)
    real(dp), intent(in) :: error                !! beside the deviation, of the largest amplitude
    real(dp) :: weight(size(amplitude))
    weight = 1/(deviation**2 + (error*maxval(abs(amplitude)))**2)
  end function amplitude_weights

  pure subroutine best_factors(amplitude, deviation, shape, factor, error)
    !! Least squares of all lines; the error is a standard deviation, larger where the shapes fit worse than they should.
    complex(dp), intent(in) :: amplitude(:, :)   !! modal constants, (sensors, lines)
    real(dp), intent(in) :: deviation(:, :)      !! of real and imaginary part, > 0, (sensors, lines)
    real(dp), intent(in) :: shape(:, :)          !! the model's modal constants, (lines, sensors)
    real(dp), intent(out) :: factor(:), error(:) !! (sensors)
    real(dp) :: weight(size(amplitude, 1), size(amplitude, 2)), known, misfit
    integer :: k, s
    do k = 1, size(amplitude, 2)
      weight(:, k) = amplitude_weights(amplitude(:, k), deviation(:, k), sensor_error)
    end do
    do s = 1, size(factor)
      known = max(sum(weight(s, :)*shape(:, s)**2), tiny(1.0_dp))
      factor(s) = sum(weight(s, :)*shape(:, s)*amplitude(s, :)%re)/known
      misfit = sum(weight(s, :)*abs(amplitude(s, :) - factor(s)*shape(:, s))**2)/max(1, 2*size(amplitude, 2) - 1)
      error(s) = sqrt(max(1.0_dp, misfit)/known)
    end do
  end subroutine best_factors

end module bw_sensor_factors
