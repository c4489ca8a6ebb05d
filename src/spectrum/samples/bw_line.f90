module bw_line
  !! One mode of a record: a pole that all sensors share, and an amplitude at each sensor after each blow.
  !!
  !! Sensor s moves as Re A_s e^(zm + Σκψ(m)), m steps after a blow. The pole z = −δ + iω is that at the blow. A mode that drifts
  !! has courses: ψ(m) = 2(m − (1 − e^(−gm))/g)/g is m² at first, and its slope levels off after 1/g steps, so that the pole moves
  !! from z to z + 2κ/g. With g = 2δ the frequency follows the square of the amplitude.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: bend_of, find_wave, has_trend, later, life_of, limited, pole_at, psi, psi_bend, psi_by_rate, psi_slope

  integer, parameter :: table = 64            !! samples between two exponentials that are computed directly
  real(dp), parameter, public :: highest = 250        !! of exponents; the exponential squared, times powers of time, is finite

  type, public :: course_type
    real(dp) :: rate = 0                      !! g, per step; 0: ψ = m² throughout
    complex(dp) :: bend = 0                   !! κ, per step²
    logical :: held = .false.                 !! the rate is fixed, not fitted
  end type course_type

  type, public :: line_type
    complex(dp) :: pole = 0                   !! z, per step
    type(course_type), allocatable :: courses(:)
    logical :: steady = .false.               !! an undamped tone that was there before the first blow
    complex(dp), allocatable :: amplitude(:, :)  !! A at the first sample after each blow, (S, stretches)
  end type line_type

contains

  pure logical function has_trend(lines, longest, count)
    !! Whether a stretch has an offset and a slope of its own: not if a line that has a period in the longest stretch has none in
    !! this one, from which a trend does not tell it.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: longest               !! samples in the longest stretch
    integer, intent(in) :: count                 !! samples in this one
    has_trend = .not. any(lines%pole%im*longest >= 2*pi .and. lines%pole%im*count < 2*pi)
  end function has_trend

  elemental real(dp) function psi(rate, m)
    !! The function ψ(m) of a course.
    real(dp), intent(in) :: rate, m
    real(dp) :: x
    x = rate*m
    if (abs(x) < 1.0e-3_dp) then
      psi = m*m*(1 - x/3*(1 - x/4*(1 - x/5)))
    else
      psi = 2*(m - (1 - exp(-x))/rate)/rate
    end if
  end function psi

  elemental real(dp) function psi_slope(rate, m)
    !! The slope of ψ.
    real(dp), intent(in) :: rate, m
    real(dp) :: x
    x = rate*m
    if (abs(x) < 1.0e-3_dp) then
      psi_slope = 2*m*(1 - x/2*(1 - x/3))
    else
      psi_slope = 2*(1 - exp(-x))/rate
    end if
  end function psi_slope

  elemental real(dp) function psi_bend(rate, m)
    !! The second derivative of ψ.
    real(dp), intent(in) :: rate, m
    psi_bend = 2*exp(-rate*m)
  end function psi_bend

  pure function psi_by_rate(rate, m) result(slopes)
    !! The derivative of ψ by the rate, and the first and second derivatives of this by m.
    real(dp), intent(in) :: rate, m
    real(dp) :: slopes(0:2), x, fall
    x = rate*m
    fall = exp(-x)
    if (abs(x) < 1.0e-2_dp) then
      slopes(0) = -m**3/3*(1 - x/2*(1 - 0.3_dp*x))
      slopes(1) = -m**2*(1 - 2*x/3*(1 - 0.375_dp*x))
    else
      slopes(0) = 2*(2*(1 - fall) - x - x*fall)/rate**3
      slopes(1) = 2*(fall + x*fall - 1)/rate**2
    end if
    slopes(2) = -2*m*fall
  end function psi_by_rate

  pure complex(dp) function bend_of(line, m)
    !! The contribution of the courses to the exponent, m steps after a blow.
    type(line_type), intent(in) :: line
    real(dp), intent(in) :: m
    integer :: c
    bend_of = 0
    do c = 1, size(line%courses)
      bend_of = bend_of + line%courses(c)%bend*psi(line%courses(c)%rate, m)
    end do
  end function bend_of

  pure complex(dp) function pole_at(line, m)
    !! The pole m steps after a blow.
    type(line_type), intent(in) :: line
    real(dp), intent(in) :: m
    integer :: c
    pole_at = line%pole
    do c = 1, size(line%courses)
      pole_at = pole_at + line%courses(c)%bend*psi_slope(line%courses(c)%rate, m)
    end do
  end function pole_at

  pure type(line_type) function later(line, m)
    !! The same motion with time counted from m steps later: ψ(m + n) = ψ(m) + ψ'(m)n + e^(−gm)ψ(n).
    type(line_type), intent(in) :: line
    real(dp), intent(in) :: m
    later = line
    later%pole = pole_at(line, m)
    later%courses%bend = line%courses%bend*exp(-line%courses%rate*m)
    later%amplitude = line%amplitude*limited(line%pole*m + bend_of(line, m))
  end function later

  pure real(dp) function life_of(line, folds, longest)
    !! The number of steps in which a line decays by `folds` e-folds, at most `longest`.
    type(line_type), intent(in) :: line
    real(dp), intent(in) :: folds, longest
    real(dp) :: low, middle
    life_of = longest
    if (-left(longest) <= folds) return
    if (size(line%courses) == 0) then
      life_of = -folds/line%pole%re
      return
    end if
    low = 0
    do while (life_of - low > 0.01_dp*life_of)
      middle = (low + life_of)/2
      if (-left(middle) <= folds) then
        low = middle
      else
        life_of = middle
      end if
    end do

  contains

    pure real(dp) function left(m)
      !! The real part of the exponent after m steps.
      real(dp), intent(in) :: m
      left = line%pole%re*m + real(bend_of(line, m), dp)
    end function left

  end function life_of

  pure subroutine find_wave(line, from, place, wave)
    !! Compute the exponential of a line at `from`, `from` + 1, … steps after a blow, or at given places after it.
    type(line_type), intent(in) :: line
    real(dp), intent(in) :: from
    real(dp), intent(in), optional :: place(:)   !! uneven times, from which `from` is subtracted
    complex(dp), intent(out) :: wave(0:)
    complex(dp) :: fine(0:table - 1), coarse
    integer :: n, first, last
    if (present(place)) then
      do n = 0, size(wave) - 1
        wave(n) = limited(line%pole*(place(n + 1) - from) + bend_of(line, place(n + 1) - from))
      end do
    else if (size(line%courses) > 0) then
      do first = 0, size(wave) - 1, table
        last = min(size(wave), first + table) - 1
        call fill_drifting(line, from + first, wave(first:last))
      end do
    else
      fine(0) = 1
      n = 1
      do while (n < table)                       ! doubles the table in each step
        fine(n:2*n - 1) = exp(line%pole*n)*fine(:n - 1)
        n = 2*n
      end do
      do n = 0, size(wave) - 1, table
        last = min(size(wave), n + table) - 1
        coarse = limited(line%pole*(from + n))
        wave(n:last) = coarse*fine(:last - n)
      end do
    end if
  end subroutine find_wave

  pure subroutine fill_drifting(line, from, wave)
    !! Compute the exponential of a line that drifts, at a few samples. Slow drifts are stepped through: the second differences of ψ
    !! are geometric.
    type(line_type), intent(in) :: line
    real(dp), intent(in) :: from
    complex(dp), intent(out) :: wave(0:)
    real(dp), parameter :: slow = 1.0e-4_dp      !! second difference of the exponent, the fourth power of which is rounding
    complex(dp) :: bends(size(line%courses)), ends(2), ratio
    real(dp) :: falls(size(line%courses))
    integer :: c, n
    ends = line%pole*[from, from + table] + [bend_of(line, from), bend_of(line, from + table)]
    bends = line%courses%bend*exp(-line%courses%rate*from)
    if (any(abs(ends%re) >= highest) .or. any(.not. abs(bends)*psi(line%courses%rate, 2.0_dp) < slow)) then
      do n = 0, size(wave) - 1
        wave(n) = limited(line%pole*(from + n) + bend_of(line, from + n))
      end do
      return
    end if
    ratio = exp(pole_at(line, from) + sum(bends*psi(line%courses%rate, 1.0_dp)))
    bends = bends*(psi(line%courses%rate, 2.0_dp) - 2*psi(line%courses%rate, 1.0_dp))
    falls = exp(-line%courses%rate)
    wave(0) = exp(ends(1))
    do n = 1, size(wave) - 1
      wave(n) = wave(n - 1)*ratio
      do c = 1, size(bends)
        ratio = ratio*(1 + bends(c)*(1 + bends(c)/2*(1 + bends(c)/3)))
        bends(c) = bends(c)*falls(c)
      end do
    end do
  end subroutine fill_drifting

  elemental complex(dp) function limited(exponent)
    !! e^x, with the real part of x limited to ±`highest`.
    complex(dp), intent(in) :: exponent
    limited = exp(cmplx(max(-highest, min(highest, exponent%re)), exponent%im, dp))
  end function limited

end module bw_line
