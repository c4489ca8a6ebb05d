module bw_modal_flow
  !! The exact motion of one mode, q̈ + cq̇ + β²q = 0, from any state: q = e^(−ct/2)[q C + (q̇ + ½cq) S] with C and S of
  !! β² − c²/4: cos and sin if it is positive (oscillating), cosh and sinh if it is negative (overdamped, or growing for
  !! β² < 0). In the latter case the exponents are combined, r − ½c = −β²/(r + ½c) with r² = ¼c² − β², to avoid
  !! cancellation and overflow. Angular frequencies and growth or decay rates follow from the same numbers.
  !!
  !! Without dimensions: times in l²/h.
  use bw_double_double, only: dd, dd_pi, sqrt, to_dd, operator(*), operator(+), operator(-), operator(/)
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: angle_of, flow, turning_square, exponent_of, slow_exponent, fast_exponent, damping_factor_beyond, energy_gain
  public :: find_angular_frequencies, find_growth_rates

  real(dp), parameter, public :: joined_below = 1.0_dp   !! rt below which the two exponentials would cancel

contains

  elemental type(dd) function turning_square(beta_squared, c) result(square)
    !! Return β² − c²/4, positive for an oscillating mode: its squared angular frequency.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c
    square = beta_squared - to_dd(0.5_dp*c)*(0.5_dp*c)
  end function turning_square

  elemental type(dd) function slow_exponent(beta_squared, c) result(exponent)
    !! Return the largest real part of the eigenvalues: r − ½c without oscillation, positive if the mode grows; −½c with
    !! oscillation.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c
    exponent = exponent_of(beta_squared, c, turning_square(beta_squared, c))
  end function slow_exponent

  elemental type(dd) function exponent_of(beta_squared, c, turning) result(exponent)
    !! Return the same if β² − c²/4 is known to more digits than follow from β² and c.
    type(dd), intent(in) :: beta_squared, turning
    real(dp), intent(in) :: c
    type(dd) :: sum
    exponent = to_dd(-0.5_dp*c)
    if (turning%hi > 0.0_dp) return
    sum = sqrt(-turning) + 0.5_dp*c
    exponent = dd()
    if (sum%hi > 0.0_dp) exponent = -(beta_squared/sum)
  end function exponent_of

  elemental real(dp) function fast_exponent(beta_squared, c) result(exponent)
    !! Return the smaller exponent −(r + ½c) of a mode that does not oscillate.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c
    type(dd) :: root
    root = sqrt(-turning_square(beta_squared, c))
    exponent = -(root%hi + 0.5_dp*c)
  end function fast_exponent

  pure real(dp) function damping_factor_beyond(beta_squared, c, stiffness, time) result(left)
    !! Bound the factor (1 + σt)e^(−σt) by which damping reduces β|q| of modes beyond this one, after initial velocity
    !! 1; σ is their slowest decay rate. Exponents of modes overdamped by stiffness damping tend to −1/b.
    type(dd), intent(in) :: beta_squared         !! > 0
    real(dp), intent(in) :: c
    real(dp), intent(in) :: stiffness            !! b of Rayleigh's law
    real(dp), intent(in) :: time
    type(dd) :: exponent
    real(dp) :: decayed
    exponent = slow_exponent(beta_squared, c)
    decayed = -exponent%hi*time
    if (stiffness > 0.0_dp) decayed = min(decayed, time/stiffness)
    decayed = max(0.0_dp, decayed)
    left = (1.0_dp + decayed)*exp(-decayed)
  end function damping_factor_beyond

  elemental subroutine flow(beta_squared, c, time, q, q_dot)
    !! Move a mode's state forward by a time ≥ 0. **Limit**: the state must not overflow.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c                !! ≥ 0; 0: undamped
    type(dd), intent(in) :: time
    real(dp), intent(inout) :: q, q_dot
    type(dd) :: square, root, phase
    real(dp) :: x
    square = turning_square(beta_squared, c)
    if (square%hi > 0.0_dp) then
      root = sqrt(square)
      phase = root*time
      x = angle_of(phase)
      call join(cos(x), sin(x)/root%hi, square%hi, c, time%hi, q, q_dot)
      return
    end if
    root = sqrt(-square)
    phase = root*time
    x = phase%hi
    if (x < joined_below) then
      call join(cosh(x), time%hi*mean_hyperbolic_cosine(x), square%hi, c, time%hi, q, q_dot)
    else
      call split(slow_exponent(beta_squared, c), -(root%hi + 0.5_dp*c), root%hi, time, q, q_dot)
    end if
  end subroutine flow

  elemental subroutine join(cosine, sine, square, c, time, q, q_dot)
    !! Combine C and S, which are of similar size, to the state.
    real(dp), intent(in) :: cosine, sine, square, c, time
    real(dp), intent(inout) :: q, q_dot
    real(dp) :: start, rate, decay
    start = q
    rate = q_dot + 0.5_dp*c*q
    decay = exp(-0.5_dp*c*time)
    q = decay*(start*cosine + rate*sine)
    q_dot = decay*(rate*cosine - square*start*sine) - 0.5_dp*c*q
  end subroutine join

  elemental subroutine split(slow, fast, root, time, q, q_dot)
    !! Combine the two exponentials, one of which may dominate, to the state. As e^x may overflow where the state does not,
    !! the growing part is multiplied by e^(x/2) twice. The low part of the exponent, up to 1e-13, is added to first order.
    type(dd), intent(in) :: slow, time
    real(dp), intent(in) :: fast, root
    real(dp), intent(inout) :: q, q_dot
    type(dd) :: exponent
    real(dp) :: growing, decaying, half
    exponent = slow*time
    growing = 0.5_dp*(q_dot - fast*q)/root
    if (growing /= 0.0_dp) then
      half = exp(0.5_dp*exponent%hi)*(1.0_dp + 0.5_dp*exponent%lo)
      growing = (growing*half)*half
    end if
    decaying = 0.5_dp*(slow%hi*q - q_dot)/root*exp(fast*time%hi)
    q = growing + decaying
    q_dot = slow%hi*growing + fast*decaying
  end subroutine split

  elemental real(dp) function energy_gain(beta_squared, c, time, q, q_dot) result(gain)
    !! Return the change of q̇² + β²q² in a time of free motion: ≤ 0, and exactly 0 without damping, so that a growing
    !! mode keeps the small difference of two huge terms.
    !!
    !! With q = a e^(st) + b e^(ft), s + f = −c and sf = β², the sum is −csa²e^(2st) + 4abβ²e^(−ct) − cfb²e^(2ft).
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c                !! ≥ 0; 0: undamped
    type(dd), intent(in) :: time             !! see `flow`
    real(dp), intent(in) :: q, q_dot         !! initial state
    type(dd) :: slow
    real(dp) :: later, later_dot, fast, a, b
    gain = 0.0_dp
    if (c == 0.0_dp) return
    if (beta_squared%hi > 0.0_dp) then       ! both terms are energies
      later = q
      later_dot = q_dot
      call flow(beta_squared, c, time, later, later_dot)
      gain = (later_dot**2 - q_dot**2) + beta_squared%hi*(later**2 - q**2)
      return
    end if
    slow = slow_exponent(beta_squared, c)
    fast = fast_exponent(beta_squared, c)
    a = (q_dot - fast*q)/(slow%hi - fast)
    b = (slow%hi*q - q_dot)/(slow%hi - fast)
    gain = c*slow%hi*a**2*(1.0_dp - exp(2.0_dp*slow%hi*time%hi)) &
      - 4.0_dp*a*b*beta_squared%hi*(1.0_dp - exp(-c*time%hi)) &
      + c*fast*b**2*(1.0_dp - exp(2.0_dp*fast*time%hi))
  end function energy_gain

  elemental real(dp) function angle_of(phase) result(angle)
    !! Return a phase modulo 2π, rad.
    type(dd), intent(in) :: phase
    type(dd) :: turns
    real(dp) :: whole
    turns = phase/(dd_pi*2.0_dp)
    whole = anint(turns%hi)
    turns = to_dd(turns%hi - whole) + turns%lo      ! the first difference is exact
    angle = 2.0_dp*dd_pi%hi*turns%hi
  end function angle_of

  elemental real(dp) function mean_hyperbolic_cosine(x) result(mean)
    !! Return sinh x/x, 1 at x = 0.
    real(dp), intent(in) :: x
    mean = 1.0_dp
    if (x > 0.0_dp) mean = sinh(x)/x
  end function mean_hyperbolic_cosine


  pure subroutine find_angular_frequencies(modes, values)
    !! Find √(β² − c²/4) in h/l² of the first modes of a set: 0 at the critical speed, missing without oscillation.
    class(mode_set), intent(in) :: modes
    real(dp), intent(out), contiguous :: values(:)     !! at most as many as the set has
    if (allocated(modes%damping)) then
      call find_roots(modes%damped_squared(:size(values)), values)
    else
      call find_roots(modes%beta_squared(:size(values)), values)
    end if
  end subroutine find_angular_frequencies

  pure subroutine find_roots(squares, roots)
    !! Find square roots, missing for negative numbers.
    type(dd), intent(in) :: squares(:)
    real(dp), intent(out), contiguous :: roots(:)
    type(dd), allocatable :: root(:)
    if (all(squares%hi >= 0.0_dp)) then
      root = sqrt(squares)            ! several times as fast for a whole list
      roots = root%hi
    else
      roots = root_of(squares)
    end if
  end subroutine find_roots

  elemental real(dp) function root_of(square)
    !! Return the square root, missing for a negative number.
    type(dd), intent(in) :: square
    type(dd) :: root
    root_of = missing
    if (square%hi < 0.0_dp) return
    root = sqrt(square)
    root_of = root%hi
  end function root_of

  pure subroutine find_growth_rates(modes, values)
    !! Find the real part of the slower eigenvalue, in h/l², of the first modes of a set. Undamped it is √(−β²) for β² < 0, else 0.
    class(mode_set), intent(in) :: modes
    real(dp), intent(out), contiguous :: values(:)     !! at most as many as the set has
    integer :: n
    n = size(values)
    if (allocated(modes%damping)) then
      associate (rate => exponent_of(modes%beta_squared(:n), modes%damping(:n), modes%damped_squared(:n)))
        values = rate%hi
      end associate
    else
      values = undamped_growth(modes%beta_squared(:n))
    end if
  end subroutine find_growth_rates

  elemental real(dp) function undamped_growth(square) result(rate)
    !! Return √(−β²) for β² < 0, else 0.
    type(dd), intent(in) :: square              !! β²
    type(dd) :: root
    rate = 0.0_dp
    if (square%hi >= 0.0_dp) return
    root = sqrt(-square)
    rate = root%hi
  end function undamped_growth

end module bw_modal_flow
