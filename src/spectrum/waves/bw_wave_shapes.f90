module bw_wave_shapes
  !! Functions of the motion of a uniform beam in one line: solutions of v'''' = α⁴ v, lengths in units of the beam's. Known end
  !! conditions leave one, two or four of them:
  !!
  !! - 'tip': clamped at ξ = 0 and no moment at ξ = 1, Φ of Eqs 18 and 20, for any mass or spring at the tip;
  !! - 'clamped': cosh αξ − cos αξ and sinh αξ − sin αξ of a beam clamped at ξ = 0;
  !! - 'any': cos, sin and the two exponentials.
  !!
  !! With 'model' there is one, from bw_model_shapes.
  !!
  !! Strain is represented by v''/α², in which cos and sin change their sign. All exponentials decay, there is no cancellation,
  !! and all functions are analytic in α: the imaginary part at α + iε is ε times the derivative.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: function_count, near, powers, shape_functions, tip_shape

  real(dp), parameter :: near = 1.9_dp         !! αξ below which power series replace differences of exponentials
  real(dp), parameter :: factorial(0:3) = [1, 1, 2, 6]

contains

  pure integer function function_count(ends)
    !! Number of functions that the end conditions leave.
    character(*), intent(in) :: ends           !! 'model', 'tip', 'clamped' or 'any'
    select case (ends)
    case ('model', 'tip')
      function_count = 1
    case ('clamped')
      function_count = 2
    case default
      function_count = 4
    end select
  end function function_count

  pure function shape_functions(ends, alpha, position, strain) result(values)
    !! The functions of displacement or strain at sensors, up to constant factors and mixtures that do not change their span.
    character(*), intent(in) :: ends
    complex(dp), intent(in) :: alpha           !! real part > 0
    real(dp), intent(in) :: position(:)        !! ξ, (n)
    logical, intent(in) :: strain
    complex(dp) :: values(size(position), function_count(ends))
    real(dp) :: sign
    integer :: i
    sign = merge(-1.0_dp, 1.0_dp, strain)
    select case (ends)
    case ('tip')
      values(:, 1) = [(tip_shape(alpha, position(i), sign), i=1, size(position))]
    case ('clamped')
      values(:, 1) = [(clamped_difference(alpha*position(i), sign), i=1, size(position))]
      values(:, 2) = [(clamped_sum(alpha, position(i), maxval(position), sign), i=1, size(position))]
    case default
      values = free_functions(alpha, position)
    end select
  end function shape_functions

  elemental complex(dp) function tip_shape(alpha, xi, sign) result(shape)
    !! The shape −Φ(ξ) = cosh αξ − cos αξ − σ (sinh αξ − sin αξ) of Eqs 18 and 20, or with sign −1 its second derivative over α².
    complex(dp), intent(in) :: alpha
    real(dp), intent(in) :: xi, sign
    shape = clamped_difference(alpha*xi, sign) + moment_free(alpha)*clamped_sum(alpha, xi, 1.0_dp, sign)
  end function tip_shape

  elemental complex(dp) function moment_free(alpha)
    !! The factor (1 − σ) e^α, σ = (cos α + cosh α)/(sin α + sinh α), that makes the tip free of moment.
    complex(dp), intent(in) :: alpha
    complex(dp) :: decay
    decay = exp(-alpha)
    if (real(alpha) < near) then
      moment_free = (sin(alpha) - cos(alpha) - decay)/((sin(alpha) + sinh(alpha))*decay)
      return
    end if
    moment_free = 2*(sin(alpha) - cos(alpha) - decay)/(1 + (2*sin(alpha) - decay)*decay)
  end function moment_free

  elemental complex(dp) function clamped_difference(z, sign) result(difference)
    !! The difference e^(−z) − cos z + sin z of the two functions of a clamped root.
    complex(dp), intent(in) :: z
    real(dp), intent(in) :: sign
    if (sign > 0 .and. real(z) < near) then
      difference = 2*(powers(z, 2) - powers(z, 3))
    else
      difference = exp(-z) - sign*(cos(z) - sin(z))
    end if
  end function clamped_difference

  elemental complex(dp) function clamped_sum(alpha, xi, far, sign) result(total)
    !! The function (sinh αξ − sin αξ) e^(−α·far) of a clamped root.
    complex(dp), intent(in) :: alpha
    real(dp), intent(in) :: xi, far, sign
    if (sign > 0 .and. real(alpha)*xi < near) then
      total = 2*powers(alpha*xi, 3)*exp(-alpha*far)
    else
      total = (exp(alpha*(xi - far)) - exp(-alpha*(xi + far)))/2 - sign*sin(alpha*xi)*exp(-alpha*far)
    end if
  end function clamped_sum

  pure function free_functions(alpha, position) result(values)
    !! All four functions about the middle of the sensors; if these are close together, as power series, which tend to
    !! 1, x, x² and x³.
    complex(dp), intent(in) :: alpha
    real(dp), intent(in) :: position(:)
    complex(dp) :: values(size(position), 4), z
    real(dp) :: half, x
    integer :: i, m
    half = (maxval(position) - minval(position))/2
    if (.not. half > 0) half = 1               ! all at one position, where any function represents the others
    do i = 1, size(position)
      x = position(i) - minval(position) - half
      z = alpha*x
      if (real(alpha)*half < near) then
        values(i, :) = [(powers(z, m)/(alpha*half)**m, m=0, 3)]
      else
        values(i, :) = [cos(z), sin(z), exp(-alpha*(half + x)), exp(-alpha*(half - x))]
      end if
    end do
  end function free_functions

  pure complex(dp) function powers(z, start)
    !! The sum z^m/m! + z^(m+4)/(m+4)! + …, m = start: (cosh z ± cos z)/2 for m = 0 and 2, (sinh z ± sin z)/2 for m = 1 and 3.
    complex(dp), intent(in) :: z
    integer, intent(in) :: start               !! 0 … 3
    complex(dp) :: term, fourth
    integer :: m
    fourth = z**4
    term = z**start/factorial(start)
    powers = term
    do m = start, start + 16, 4
      term = term*fourth/(real(m + 1, dp)*(m + 2)*(m + 3)*(m + 4))
      powers = powers + term
    end do
  end function powers

end module bw_wave_shapes
