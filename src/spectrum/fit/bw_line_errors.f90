module bw_line_errors
  !! The errors of the lines of a fit due to noise: standard deviations of decays, frequencies and amplitudes, with all unknowns
  !! free. They are the Cramér–Rao bounds for the information in the fit's rows.
  use bw_band_fit, only: free_of, reduced_type, slope_place, slopes_of, unknown_place
  use bw_kinds, only: dp
  use bw_line, only: line_type, psi_by_rate, psi_slope
  use bw_line_projection, only: deviation_of
  use bw_triangle, only: eliminate, triangle_of
  implicit none (type, external)
  private
  public :: amplitude_deviation, amplitude_noise, drift_deviation, line_errors_of, pole_deviation

  type, public :: line_errors
    !! A fit in the form from which its errors follow.
    type(line_type), allocatable :: lines(:)
    type(reduced_type), allocatable :: reduced(:)
    real(dp), allocatable :: triangle(:, :), length(:)  !! of the slopes by the free unknowns
  end type line_errors

contains

  function line_errors_of(lines, reduced) result(errors)
    !! The errors of a fit.
    type(line_type), intent(in) :: lines(:)
    type(reduced_type), intent(in) :: reduced(:)
    type(line_errors) :: errors
    errors%lines = lines
    errors%reduced = reduced
    call triangle_of(slopes_of(reduced, lines), errors%triangle, errors%length)
  end function line_errors_of

  pure function pole_deviation(errors, k, m) result(deviation)
    !! Standard deviations of real and imaginary part of line k's pole, m steps after a blow; huge if undetermined, 0 if fixed.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: k
    real(dp), intent(in) :: m
    real(dp) :: deviation(2)
    integer :: part
    deviation = [(exponent_deviation(errors, slope_of_pole(errors, k, m, part, 1)), part=0, 1)]
  end function pole_deviation

  pure real(dp) function drift_deviation(errors, k, m) result(deviation)
    !! Standard deviation of the change of the imaginary part of line k's pole from the blow to m steps after it.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: k
    real(dp), intent(in) :: m
    deviation = exponent_deviation(errors, slope_of_pole(errors, k, m, 1, 0))
  end function drift_deviation

  pure function slope_of_pole(errors, k, m, part, at_blow) result(slope)
    !! The derivatives of the real (part 0) or imaginary part (1) of line k's pole, m steps after a blow, by the unknowns.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: k, part
    integer, intent(in) :: at_blow               !! 1: the pole; 0: its change since the blow
    real(dp), intent(in) :: m
    real(dp) :: slope(unknown_place(errors%lines, size(errors%lines) + 1) - 1)
    real(dp) :: by_rate(0:2)
    integer :: c, i
    i = unknown_place(errors%lines, k)
    slope = 0
    slope(i + part) = at_blow
    do c = 1, size(errors%lines(k)%courses)
      associate (course => errors%lines(k)%courses(c))
        slope(i + 3*c - 1 + part) = psi_slope(course%rate, m)
        by_rate = psi_by_rate(course%rate, m)
        slope(i + 3*c + 1) = by_rate(1)*merge(course%bend%re, course%bend%im, part == 0)
      end associate
    end do
  end function slope_of_pole

  pure real(dp) function exponent_deviation(errors, slope) result(deviation)
    !! Standard deviation of a sum of the unknowns in the lines' exponents with these factors.
    type(line_errors), intent(in) :: errors
    real(dp), intent(in) :: slope(:)             !! (unknowns)
    deviation = deviation_of(errors%triangle, errors%length, pack(slope, free_of(errors%lines)))
  end function exponent_deviation

  pure real(dp) function amplitude_deviation(errors, stretch, k, direction) result(total)
    !! The standard deviation of the sum over components of line k's white amplitudes in a stretch, each times a direction in
    !! its plane: the effect of noise at known poles, and that of the poles' errors.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: stretch, k
    real(dp), intent(in) :: direction(:, :)      !! (2, S)
    real(dp) :: slope(unknown_place(errors%lines, size(errors%lines) + 1) - 1), own(size(direction, 2))
    complex(dp) :: a
    real(dp), dimension(errors%reduced(1)%linear) :: gradient, y
    integer :: p, s, sensor, j, i, c, n
    logical :: determined
    total = huge(1.0_dp)
    slope = 0
    own = 0
    do p = 1, size(errors%reduced)
      if (errors%reduced(p)%stretch /= stretch) cycle
      associate (fit => errors%reduced(p))
        if (size(fit%triangle, 1) < fit%linear) return
        do s = 1, size(fit%linear_part, 2)
          sensor = fit%sensors(1) + s - 1
          if (all(abs(direction(:, sensor)) <= 0)) cycle
          gradient = 0
          gradient(2*k - 1:2*k) = direction(:, sensor)
          call eliminate(fit%triangle(:fit%linear, :fit%linear), fit%length(:fit%linear), gradient, y, determined)
          if (.not. determined) return
          own(sensor) = norm2(y)
          do j = 1, size(errors%lines)
            a = cmplx(fit%linear_part(2*j - 1, s), fit%linear_part(2*j, s), dp)
            i = unknown_place(errors%lines, j)
            c = fit%linear + slope_place(errors%lines, j)
            slope(i:i + 1) = slope(i:i + 1) - [product_of(c, a), product_of(c, (0, 1)*a)]
            do n = 1, size(errors%lines(j)%courses)
              slope(i + 3*n - 1:i + 3*n + 1) = slope(i + 3*n - 1:i + 3*n + 1) - [product_of(c + 4*n - 2, a), &
                & product_of(c + 4*n - 2, (0, 1)*a), product_of(c + 4*n, errors%lines(j)%courses(n)%bend*a)]
            end do
          end do
        end do
      end associate
    end do
    total = exponent_deviation(errors, slope)
    if (total < huge(1.0_dp)) total = norm2([own, total])

  contains

    pure real(dp) function product_of(c, amplitude)
      !! The product of y and the slopes in two columns, for a line of this amplitude.
      integer, intent(in) :: c
      complex(dp), intent(in) :: amplitude
      associate (fit => errors%reduced(p))
        product_of = amplitude%re*dot_product(y, fit%triangle(:fit%linear, c))*fit%length(c) + &
          & amplitude%im*dot_product(y, fit%triangle(:fit%linear, c + 1))*fit%length(c + 1)
      end associate
    end function product_of

  end function amplitude_deviation

  pure real(dp) function amplitude_noise(errors, part, k) result(deviation)
    !! The standard deviation of the real part of line k's white amplitude in a part of the band at known poles; that of the
    !! imaginary part is the same, up to the contribution of a period at the part's ends.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: part, k
    real(dp) :: gradient(errors%reduced(part)%linear)
    deviation = huge(1.0_dp)
    gradient = 0
    gradient(2*k - 1) = 1
    associate (fit => errors%reduced(part), n => errors%reduced(part)%linear)
      if (size(fit%triangle, 1) >= n) deviation = deviation_of(fit%triangle(:n, :n), fit%length(:n), gradient)
    end associate
  end function amplitude_noise

end module bw_line_errors
