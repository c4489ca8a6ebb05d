module bw_noise
  !! The noise of a record: the filters that make it white and independent, and their effect on lines.
  !!
  !! Sensors y, mixed into components c = yM if they share noise, pass a prediction-error filter each. The filter looks ahead,
  !! so that none after a blow is lost. The last samples of a stretch are predicted from fewer: these errors are in the likelihood,
  !! but not in the rows that lines are fitted to. An exponential e^(zm) is multiplied by H(z) = Σ h_i e^(zi).
  use bw_kinds, only: dp
  use bw_lapack, only: dgemm
  use bw_line, only: line_type
  implicit none (type, external)
  private
  public :: amplitude_of, ends_of, gain_of, mix, mixed_amplitude, squares_at_end, whiten, white_amplitude

  type, public :: noise_type
    real(dp), allocatable :: filter(:, :)    !! h of each component, over the standard deviation of its prediction error, (0:p, S)
    integer, allocatable :: order(:)         !! (S)
    integer :: lost = 0                      !! the highest order: number of samples at the end of each stretch without a row
    real(dp), allocatable :: ends(:, :, :)   !! the predictors of the last of these, row m of the last but m, (0:p, 0:p - 1, S)
    real(dp), allocatable :: mixing(:, :)    !! M, (S, S); unallocated: each sensor is a component
    real(dp), allocatable :: unmixing(:, :)  !! its inverse
    real(dp) :: cost = 0                     !! −2 ln L of the residual that was used, plus the penalty of its coefficients
  end type noise_type

contains

  pure subroutine mix(noise, values, chosen, components)
    !! Find some components of the sensors' values.
    type(noise_type), intent(in) :: noise
    real(dp), intent(in), contiguous :: values(:, :)      !! (N or more, S)
    integer, intent(in) :: chosen(:)
    real(dp), intent(out), contiguous :: components(:, :) !! (N, those)
    integer :: c
    associate (n => size(components, 1), sensors => size(values, 2))
      if (allocated(noise%mixing)) then
        call dgemm('N', 'N', n, size(chosen), sensors, 1.0_dp, values, size(values, 1), noise%mixing(:, chosen), sensors, &
          & 0.0_dp, components, n)
      else
        do c = 1, size(chosen)
          components(:, c) = values(:n, chosen(c))
        end do
      end if
    end associate
  end subroutine mix

  pure function mixed_amplitude(noise, amplitude) result(mixed)
    !! The amplitudes of a line in the components, (S, stretches).
    type(noise_type), intent(in) :: noise
    complex(dp), intent(in) :: amplitude(:, :)
    complex(dp) :: mixed(size(amplitude, 1), size(amplitude, 2))
    mixed = amplitude
    if (allocated(noise%mixing)) mixed = matmul(transpose(noise%mixing), amplitude)
  end function mixed_amplitude

  pure subroutine whiten(filter, values)
    !! Replace the values of one component by prediction errors, in place; the last ones are 0.
    real(dp), intent(in) :: filter(0:)       !! h
    real(dp), intent(inout) :: values(:)
    integer, parameter :: at_once = 1024     !! values that fit a processor's cache
    real(dp) :: part(at_once)
    integer :: first, last, i, n, p
    n = size(values)
    p = ubound(filter, 1)
    do first = 1, n - p, at_once
      last = min(n - p, first + at_once - 1)
      part(:last - first + 1) = filter(0)*values(first:last)
      do i = 1, p
        part(:last - first + 1) = part(:last - first + 1) + filter(i)*values(first + i:last + i)
      end do
      values(first:last) = part(:last - first + 1)
    end do
    values(max(1, n - p + 1):) = 0
  end subroutine whiten

  pure function ends_of(filter) result(ends)
    !! The predictors of the last samples of a stretch: row m is that of the last but m from its m successors, over the standard
    !! deviation of its error, by Levinson's recursion downwards, (0:p, 0:p − 1).
    real(dp), intent(in) :: filter(0:)       !! h
    real(dp) :: ends(0:ubound(filter, 1), 0:ubound(filter, 1) - 1)
    real(dp) :: h(0:ubound(filter, 1)), reflection
    integer :: m
    ends = 0
    h = filter
    do m = ubound(h, 1) - 1, 0, -1
      reflection = h(m + 1)/h(0)
      h(:m) = (h(:m) - reflection*h(m + 1:1:-1))/sqrt(1 - reflection**2)
      ends(:m, m) = h(:m)
    end do
  end function ends_of

  pure real(dp) function squares_at_end(noise, values) result(squares)
    !! The sum of squared prediction errors of the last samples of a stretch that have no row, over their variances.
    type(noise_type), intent(in) :: noise
    real(dp), intent(in) :: values(:, :)     !! of the components, (at most p, S)
    integer :: c, m, n
    n = size(values, 1)
    squares = 0
    do c = 1, size(values, 2)
      do m = 0, min(n, noise%order(c)) - 1
        squares = squares + dot_product(noise%ends(:m, m, c), values(n - m:, c))**2
      end do
    end do
  end function squares_at_end

  pure complex(dp) function gain_of(filter, pole) result(gain)
    !! The factor H(z) of an exponential.
    real(dp), intent(in) :: filter(0:)
    complex(dp), intent(in) :: pole
    complex(dp) :: step
    integer :: i
    step = exp(pole)
    gain = 0
    do i = ubound(filter, 1), 0, -1
      gain = gain*step + filter(i)
    end do
  end function gain_of

  pure function white_amplitude(noise, line) result(amplitude)
    !! The amplitudes of a line in the white components, (S, stretches).
    type(noise_type), intent(in) :: noise
    type(line_type), intent(in) :: line
    complex(dp) :: amplitude(size(line%amplitude, 1), size(line%amplitude, 2))
    integer :: c
    amplitude = mixed_amplitude(noise, line%amplitude)
    do c = 1, size(amplitude, 1)
      amplitude(c, :) = gain_of(noise%filter(:noise%order(c), c), line%pole)*amplitude(c, :)
    end do
  end function white_amplitude

  pure function amplitude_of(noise, pole, white) result(amplitude)
    !! The amplitudes at the sensors of a line with these amplitudes in the white components, (S, stretches).
    type(noise_type), intent(in) :: noise
    complex(dp), intent(in) :: pole, white(:, :)
    complex(dp) :: amplitude(size(white, 1), size(white, 2))
    integer :: c
    do c = 1, size(white, 1)
      amplitude(c, :) = white(c, :)/gain_of(noise%filter(:noise%order(c), c), pole)
    end do
    if (allocated(noise%mixing)) amplitude = matmul(transpose(noise%unmixing), amplitude)
  end function amplitude_of

end module bw_noise
