module bw_load_step
  !! A time step of modes under polynomial or harmonic loads, exact: q̈ + cq̇ + β²q = x^j or e^(iΩs) from rest, with x
  !! from −1 to 1 in the step, and the free flow of the initial state. The operators depend only on the length of the
  !! step, so steps of one length share them.
  use bw_double_double, only: dd
  use bw_force_response, only: find_force_response, force_degree, highest_power, powers_of
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow
  implicit none (type, external)
  private
  public :: load_step_of, tone_response

  type, public :: load_step
    real(dp) :: length = -1.0_dp                   !! l²/h; below 0: not computed yet
    real(dp), allocatable :: moved(:, :)           !! final q and v by initial q and v: q by q, q by v, v by q, v by v, (modes, 4)
    real(dp), allocatable :: pushed(:, :, :)       !! q and v by loads x^j, (modes, 2, 0:degree)
    complex(dp), allocatable :: tone(:, :, :)      !! q and v by e^(iΩs) of each load, (modes, 2, loads)
  contains
    procedure :: advance
  end type load_step

contains

  pure type(load_step) function load_step_of(beta_squared, c, time, frequency, degree) result(step)
    !! Compute the operators of a step.
    type(dd), intent(in) :: beta_squared(:)        !! (modes)
    real(dp), intent(in) :: c(:)
    type(dd), intent(in) :: time                   !! length of the step > 0
    real(dp), intent(in) :: frequency(:)           !! Ω of each load; 0: no tone
    integer, intent(in) :: degree                  !! of the loads
    real(dp) :: unit(2, 2)
    real(dp), dimension(1, 0:force_degree) :: displacement, velocity
    real(dp) :: ends(1, 0:highest_power)
    integer :: j, k
    ends = powers_of([1.0_dp])
    step%length = time%hi
    allocate (step%moved(size(c), 4), step%pushed(size(c), 2, 0:degree), step%tone(size(c), 2, size(frequency)))
    do k = 1, size(c)
      unit = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
      call flow(beta_squared(k), c(k), time, unit(1, :), unit(2, :))
      step%moved(k, :) = [unit(1, :), unit(2, :)]
      call find_force_response(beta_squared(k)%hi, c(k), time%hi, ends, unit(1:1, 2), unit(2:2, 2), displacement, velocity)
      step%pushed(k, 1, :) = displacement(1, :degree)
      step%pushed(k, 2, :) = velocity(1, :degree)
      step%tone(k, :, :) = 0.0_dp
      do j = 1, size(frequency)
        if (frequency(j) > 0.0_dp) step%tone(k, :, j) = &
          tone_response(beta_squared(k)%hi, c(k), time%hi, frequency(j), step%moved(k, :))
      end do
    end do
  end function load_step_of

  pure function tone_response(beta_squared, c, h, frequency, moved) result(state)
    !! Return displacement and velocity after a time h under e^(iΩs) from rest. Far from resonance they are the steady
    !! response less the free one. Near it they follow from the roots s₁, s₂ of s² + cs + β²: (E(s₁) − E(s₂))/(s₁ − s₂),
    !! E(s) = ∫₀ʰ e^(s(h−w)) e^(iΩw) dw. If all phases in the step are small, a power series is used; so the roots in
    !! the quotient are never close.
    real(dp), intent(in) :: beta_squared, c, h, frequency
    real(dp), intent(in) :: moved(4)               !! free flow, as in a step
    complex(dp) :: state(2)
    complex(dp), parameter :: i = (0.0_dp, 1.0_dp)
    complex(dp) :: s(2), e(2), difference, steady
    real(dp) :: turn, beta_turn
    turn = frequency*h
    beta_turn = sqrt(abs(beta_squared))*h
    if (max(beta_turn, 0.5_dp*c*h, turn) < 1.0_dp) then
      state = tone_series(beta_squared*h**2, c*h, turn)*[h**2, h]
      return
    end if
    difference = cmplx(beta_squared - frequency**2, c*frequency, dp)
    if (abs(difference)*h**2 >= 0.5_dp*max(1.0_dp, beta_turn + turn)) then
      steady = 1.0_dp/difference
      state(1) = steady*(exp(i*turn) - moved(1) - moved(2)*i*frequency)
      state(2) = steady*(i*frequency*exp(i*turn) - moved(3) - moved(4)*i*frequency)
    else                                           ! an oscillating mode with little damping
      s = -0.5_dp*c + [i, -i]*sqrt(cmplx(beta_squared - 0.25_dp*c**2, 0.0_dp, dp))
      e = h*exp(0.5_dp*(s + i*frequency)*h)*mean_exponential(0.5_dp*(i*frequency - s)*h)
      state(1) = (e(1) - e(2))/(s(1) - s(2))
      state(2) = (s(1)*e(1) - s(2)*e(2))/(s(1) - s(2))
    end if
  end function tone_response

  elemental complex(dp) function mean_exponential(z) result(mean)
    !! Return sinh z/z.
    complex(dp), intent(in) :: z
    if (abs(z) < 1.0e-2_dp) then
      mean = 1.0_dp + z**2/6.0_dp*(1.0_dp + z**2/20.0_dp*(1.0_dp + z**2/42.0_dp*(1.0_dp + z**2/72.0_dp)))
    else
      mean = 0.5_dp*(exp(z) - exp(-z))/z
    end if
  end function mean_exponential

  pure function tone_series(square, damping, turn) result(state)
    !! Solve y″ + Cy′ + By = e^(iΘu) at u = 1, from rest at u = 0.
    real(dp), intent(in) :: square, damping, turn  !! B ≤ 1, C ≤ 2 and Θ ≤ 1
    complex(dp) :: state(2)
    integer, parameter :: terms = 26
    complex(dp) :: before, coefficient, drive, next
    integer :: m
    before = 0.0_dp
    coefficient = 0.5_dp
    drive = 1.0_dp                                 ! (iΘ)^(m − 2)/(m − 2)!
    state = [cmplx(0.5_dp, 0.0_dp, dp), cmplx(1.0_dp, 0.0_dp, dp)]
    do m = 3, terms
      drive = drive*cmplx(0.0_dp, turn, dp)/(m - 2)
      next = (drive - damping*(m - 1)*coefficient - square*before)/(m*(m - 1))
      before = coefficient
      coefficient = next
      state = state + [coefficient, m*coefficient]
    end do
  end function tone_series

  pure subroutine advance(self, drive, power, tone, q, v)
    !! Move the state to the end of the step.
    class(load_step), intent(in) :: self
    real(dp), intent(in) :: drive(:, :)            !! acceleration of each mode under a load of 1, (modes, loads)
    real(dp), intent(in) :: power(0:, :)           !! of the loads in the step, (0:degree, loads)
    complex(dp), intent(in) :: tone(:)             !! (loads)
    real(dp), intent(inout) :: q(:), v(:)          !! (modes)
    real(dp) :: start
    integer :: j, k, l
    do k = 1, size(q)
      start = q(k)
      q(k) = self%moved(k, 1)*start + self%moved(k, 2)*v(k)
      v(k) = self%moved(k, 3)*start + self%moved(k, 4)*v(k)
    end do
    do l = 1, size(tone)
      do j = 0, ubound(power, 1)
        if (power(j, l) == 0.0_dp) cycle
        q = q + (power(j, l)*drive(:, l))*self%pushed(:, 1, j)
        v = v + (power(j, l)*drive(:, l))*self%pushed(:, 2, j)
      end do
    end do
    do j = 1, size(tone)
      if (abs(tone(j)) == 0.0_dp) cycle
      do k = 1, size(q)
        q(k) = q(k) + drive(k, j)*real(self%tone(k, 1, j)*tone(j))
        v(k) = v(k) + drive(k, j)*real(self%tone(k, 2, j)*tone(j))
      end do
    end do
  end subroutine advance

end module bw_load_step
