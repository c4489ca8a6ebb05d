module bw_tapered_errors
  !! What noise does to the lines of a fit: standard deviations of decays, frequencies and amplitudes, all unknowns being free.
  use bw_kinds, only: dp
  use bw_line_projection, only: deviation_of
  use bw_tapered_fit, only: reduced_type, slopes
  use bw_triangle, only: eliminate, triangle_of
  implicit none (type, external)
  private
  public :: amplitude_deviation, decay_deviation, frequency_deviation, line_errors_of

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

  pure real(dp) function decay_deviation(errors, j)
    !! Of line j, over half the record; 0 where the decay is held.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    decay_deviation = rate_deviation(errors, 2*j - 1)
  end function decay_deviation

  pure real(dp) function frequency_deviation(errors, j)
    !! Of 2π·frequency of line j, over half the record.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    frequency_deviation = rate_deviation(errors, 2*j)
  end function frequency_deviation

  pure real(dp) function rate_deviation(errors, i)
    !! Of one unknown in the exponents.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: i
    real(dp) :: slope(size(errors%reduced%free))
    slope = 0
    slope(i) = 1
    rate_deviation = position_deviation(errors, slope)
  end function rate_deviation

  pure real(dp) function position_deviation(errors, slope)
    !! Of a sum of the coefficients in the lines' exponents with these factors.
    type(line_errors), intent(in) :: errors
    real(dp), intent(in) :: slope(:)           !! (slopes of the fit)
    position_deviation = deviation_of(errors%triangle, errors%length, pack(slope, errors%reduced%free))
  end function position_deviation

  pure real(dp) function amplitude_deviation(errors, j, direction) result(total)
    !! The standard deviation of the sum over sensors of line j's amplitudes, each times a direction in its plane: what noise does
    !! to them at known decays and frequencies, and what their errors add. The amplitudes are those at the first sample. Those of a
    !! line that grows are given e^(growth) times as large, and so is their deviation.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp), intent(in) :: direction(:, :)    !! (2, S)
    real(dp) :: slope(size(errors%reduced%free)), own(size(direction, 2)), one, other
    real(dp), dimension(errors%reduced%linear) :: gradient, y
    integer :: s, k, i, c
    logical :: determined
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
          i = 2*k - 1
          c = fit%linear + i
          one = dot_product(y, fit%triangle(:fit%linear, c))*fit%length(c)
          other = dot_product(y, fit%triangle(:fit%linear, c + 1))*fit%length(c + 1)
          if (k == j) then                     ! slopes are about the record's middle, and the first sample is at u = −1
            one = one + direction(1, s)
            other = other + direction(2, s)
          end if
          slope(i:i + 1) = slope(i:i + 1) - turned(one, other, fit%linear_part(2*k - 1:2*k, s))
        end do
      end do
    end associate
    total = position_deviation(errors, slope)
    if (total < huge(1.0_dp)) total = norm2([own, total])
  end function amplitude_deviation

  pure function turned(one, other, amplitude) result(slope)
    !! The slopes by −decay and by 2π·frequency of a line of an amplitude, where those of amplitudes 1 and i are known.
    real(dp), intent(in) :: one, other, amplitude(2)
    real(dp) :: slope(2)
    slope = [amplitude(1)*one + amplitude(2)*other, -amplitude(2)*one + amplitude(1)*other]
  end function turned

end module bw_tapered_errors
