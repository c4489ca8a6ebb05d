module bw_line_errors
  !! What noise does to the lines of a fit: standard deviations of decays, frequencies and amplitudes, all unknowns being free.
  use bw_band_fit, only: reduced_type, slopes
  use bw_kinds, only: dp
  use bw_triangle, only: eliminate, triangle_of
  implicit none (type, external)
  private
  public :: amplitude_deviation, amplitude_noise, best_time, decay_deviation, frequency_deviation, line_errors_of, noise_share, &
    & sensors_of

  integer, parameter :: looks = 32             !! times, less one, among which the best one is
  real(dp), parameter :: most_share = 0.9_dp   !! of noise in a line's squares

  type, public :: line_errors
    !! A fit as its errors follow from it.
    type(reduced_type) :: reduced
    real(dp), allocatable :: weight(:)         !! one over the noise's variance, (S)
    real(dp), allocatable :: triangle(:, :), length(:)  !! of the slopes by decays and frequencies
  end type line_errors

contains

  function line_errors_of(reduced, weight) result(errors)
    !! The errors of a fit in noise of these variances.
    type(reduced_type), intent(in) :: reduced
    real(dp), intent(in) :: weight(:)
    type(line_errors) :: errors
    errors%reduced = reduced
    errors%weight = weight
    call triangle_of(slopes(reduced, weight), errors%triangle, errors%length)
  end function line_errors_of

  pure real(dp) function best_time(errors, j) result(best)
    !! The time, −1 … 1 over the record, at which the decay and the frequency of line j are known best. Of one that does not drift
    !! they are the same at all times, and this is 0. Of one that drifts they are known there about as well as if it did not, and
    !! are about those that a fit without a drift has.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp) :: deviation, least, at
    integer :: i
    best = 0
    if (powers_of(errors, j) == 1) return
    least = huge(1.0_dp)
    do i = 0, looks
      at = 2*i/real(looks, dp) - 1
      deviation = max(decay_deviation(errors, j, at), frequency_deviation(errors, j, at))
      if (.not. deviation < least) cycle
      least = deviation
      best = at
    end do
  end function best_time

  pure integer function powers_of(errors, j)
    !! How many powers of time are in the exponent of line j.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    powers_of = (errors%reduced%first(j + 1) - errors%reduced%first(j))/2
  end function powers_of

  pure real(dp) function decay_deviation(errors, j, at)
    !! Of line j, over half the record; 0 where the decay is held.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp), intent(in), optional :: at       !! time, −1 … 1 over the record; the middle if absent
    decay_deviation = rate_deviation(errors, j, 0, at)
  end function decay_deviation

  pure real(dp) function frequency_deviation(errors, j, at)
    !! Of 2π·frequency of line j, over half the record.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp), intent(in), optional :: at       !! as above
    frequency_deviation = rate_deviation(errors, j, 1, at)
  end function frequency_deviation

  pure real(dp) function rate_deviation(errors, j, part, at)
    !! Of what the exponent of line j, by powers of time, changes by at a time.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    integer, intent(in) :: part                !! 0: −decay, 1: 2π·frequency
    real(dp), intent(in), optional :: at
    real(dp) :: slope(size(errors%reduced%free))
    integer :: m
    slope = 0
    slope(errors%reduced%first(j) + part) = 1
    if (present(at)) then
      do m = 2, powers_of(errors, j)
        slope(errors%reduced%first(j) + 2*(m - 1) + part) = m*at**(m - 1)
      end do
    end if
    rate_deviation = position_deviation(errors, slope)
  end function rate_deviation

  pure real(dp) function position_deviation(errors, slope)
    !! Of a sum of the coefficients in the lines' exponents with these factors.
    type(line_errors), intent(in) :: errors
    real(dp), intent(in) :: slope(:)           !! (slopes of the fit)
    real(dp) :: y(size(errors%length))
    logical :: determined
    call eliminate(errors%triangle, errors%length, pack(slope, errors%reduced%free), y, determined)
    position_deviation = merge(norm2(y), huge(1.0_dp), determined)
  end function position_deviation

  pure real(dp) function amplitude_deviation(errors, j, direction, last) result(total)
    !! The standard deviation of the sum over sensors of line j's amplitudes, each times a direction in its plane: what noise does
    !! to them at known decays and frequencies, and what their errors add. The amplitudes are those at the first sample, or at the
    !! last. Those of a line that grows are given e^(growth) times as large, and so is their deviation.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp), intent(in) :: direction(:, :)    !! (2, S)
    logical, intent(in), optional :: last      !! true: the errors at the last sample; absent: at the first
    real(dp) :: slope(size(errors%reduced%free)), own(size(direction, 2)), one, other
    real(dp), dimension(errors%reduced%linear) :: gradient, y
    integer :: s, k, i, c, sign_of_power
    logical :: determined, at_last
    at_last = .false.
    if (present(last)) at_last = last
    total = huge(1.0_dp)
    slope = 0
    own = 0
    associate (fit => errors%reduced)
      do s = 1, size(direction, 2)
        if (all(abs(direction(:, s)) <= 0)) cycle
        gradient = 0
        gradient(2*j - 1:2*j) = direction(:, s)
        call eliminate(fit%triangle(:fit%linear, :fit%linear), fit%length(:fit%linear), gradient, y, determined)
        if (.not. determined) return
        own(s) = norm2(y)/sqrt(errors%weight(s))
        do k = 1, fit%lines
          do i = fit%first(k), fit%first(k + 1) - 1, 2
            c = fit%linear + i
            one = dot_product(y, fit%triangle(:fit%linear, c))*fit%length(c)
            other = dot_product(y, fit%triangle(:fit%linear, c + 1))*fit%length(c + 1)
            if (k == j) then                   ! slopes are about the record's middle, and its ends are at u = ∓1
              sign_of_power = merge(-1, (-1)**((i - fit%first(k))/2), at_last)
              one = one + direction(1, s)*sign_of_power
              other = other + direction(2, s)*sign_of_power
            end if
            slope(i:i + 1) = slope(i:i + 1) - turned(one, other, fit%linear_part(2*k - 1:2*k, s))
          end do
        end do
      end do
    end associate
    total = position_deviation(errors, slope)
    if (total < huge(1.0_dp)) total = norm2([own, total])
  end function amplitude_deviation

  pure real(dp) function amplitude_noise(errors, j, s) result(deviation)
    !! The standard deviation of the real part of line j's amplitude at sensor s at known decays and frequencies; that of the
    !! imaginary part is the same but for what is within a period of the record's ends.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j, s
    deviation = white_deviation(errors, j)
    if (deviation < huge(1.0_dp)) deviation = deviation/sqrt(errors%weight(s))
  end function amplitude_noise

  pure real(dp) function white_deviation(errors, j) result(deviation)
    !! The same in noise of variance 1.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp), dimension(errors%reduced%linear) :: gradient, y
    logical :: determined
    gradient = 0
    gradient(2*j - 1) = 1
    associate (fit => errors%reduced)
      call eliminate(fit%triangle(:fit%linear, :fit%linear), fit%length(:fit%linear), gradient, y, determined)
    end associate
    deviation = merge(norm2(y), huge(1.0_dp), determined)
  end function white_deviation

  pure real(dp) function noise_share(errors, j) result(share)
    !! The part of the squares of line j's amplitudes, each sensor's over its noise, that noise is expected to have added; 0 where
    !! the amplitudes are not determined. It is small where a sensor shows the line, and large where only many together do.
    !!
    !! The slopes of a fit grow with these amplitudes, so that the information F that they tell is F (1 − share) in truth: a
    !! deviation is 1/√(1 − share) times as large. As noise turns the slopes too, estimates scatter by as much more than that
    !! bound of known amplitudes: the factor of Stoica and Nehorai (1990) for one line.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp) :: white
    white = white_deviation(errors, j)
    share = 0
    if (white < huge(1.0_dp)) share = min(most_share, size(errors%weight)*2*white**2/max(sum(squares_of(errors, j)), tiny(1.0_dp)))
  end function noise_share

  pure real(dp) function sensors_of(errors, j) result(sensors)
    !! How many equal sensors would tell line j as unevenly as these do: 1 … S, 1 where one tells nearly all.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp) :: squares(size(errors%weight))
    squares = squares_of(errors, j)
    squares = squares/max(maxval(squares), tiny(1.0_dp))
    sensors = max(1.0_dp, sum(squares)**2/max(sum(squares**2), tiny(1.0_dp)))
  end function sensors_of

  pure function squares_of(errors, j) result(squares)
    !! The squares of line j's amplitudes over the variances of the noise, (S).
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp) :: squares(size(errors%weight))
    associate (a => errors%reduced%linear_part)
      squares = errors%weight*(a(2*j - 1, :)**2 + a(2*j, :)**2)
    end associate
  end function squares_of

  pure function turned(one, other, amplitude) result(slope)
    !! The slopes by −decay and by 2π·frequency of a line of an amplitude, where those of amplitudes 1 and i are known.
    real(dp), intent(in) :: one, other, amplitude(2)
    real(dp) :: slope(2)
    slope = [amplitude(1)*one + amplitude(2)*other, -amplitude(2)*one + amplitude(1)*other]
  end function turned

end module bw_line_errors
