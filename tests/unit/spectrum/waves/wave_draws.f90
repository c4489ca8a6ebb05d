module wave_draws
  !! Lines of uniform beams at sensors, from closed forms in quadruple precision, with noise; and how often intervals hold what is
  !! true. BEAMWAVE_DRAWS multiplies the number of draws, by hand.
  use bw_kinds, only: dp, qp
  use bw_missing, only: is_missing
  use bw_sensor_lines, only: measured_lines, sensor_facts, sensor_waves
  use bw_sensor_waves, only: measure_sensor_waves
  implicit none (type, external)
  private
  public :: beam_lines, facts_of, judge, noisy

  real(qp), parameter :: pi = acos(-1.0_qp)
  real(dp), parameter, public :: length = 0.7_dp, stiffness_root = 4.5_dp, turning = 12.0_dp  !! m, m²/s, rad/s

  type, public :: truth_type
    !! A beam's first modes; all of dimension (mode).
    real(dp), allocatable :: wavenumber(:), phase_velocity(:), group_velocity(:)
  end type truth_type

  type, public :: tally_type
    integer :: lines = 0           !! drawn
    integer :: given = 0           !! with a wave number
    integer :: held(3) = 0         !! wave number, phase and group velocity inside their intervals
    integer :: groups = 0          !! with a group velocity
    integer :: aliases = 0         !! wave numbers more than 3 of their errors away
    integer :: noted = 0           !! shapes that were said to misfit
    integer :: dispersions(2) = 0, dispersions_held(2) = 0  !! √(EI/ρA) and ω
  end type tally_type

contains

  type(sensor_facts) function facts_of(ends, position, quantity) result(facts)
    !! Sensors; quantities by their first letters, one for each or one for all.
    character(*), intent(in) :: ends, quantity
    real(dp), intent(in) :: position(:)
    integer :: s
    facts%position = position
    facts%length = length
    facts%ends = ends
    allocate (facts%quantity(size(position)))
    do s = 1, size(position)
      select case (quantity(min(s, len(quantity)):min(s, len(quantity))))
      case ('d')
        facts%quantity(s)%text = 'displacement'
      case ('v')
        facts%quantity(s)%text = 'velocity'
      case ('a')
        facts%quantity(s)%text = 'acceleration'
      case ('s')
        facts%quantity(s)%text = 'strain'
      end select
    end do
  end function facts_of

  subroutine beam_lines(facts, mass_ratio, modes, lines, truth)
    !! The first modes of a beam without noise: clamped with a mass at the tip, clamped at both ends, or free at both, as the ends
    !! that are known ask for. Each mode has an amplitude and a phase of its own, and decays a little.
    type(sensor_facts), intent(in) :: facts
    real(dp), intent(in) :: mass_ratio         !! of the mass at the tip
    integer, intent(in) :: modes
    type(measured_lines), intent(out) :: lines
    type(truth_type), intent(out) :: truth
    real(qp) :: alpha, k, beta
    complex(qp) :: pole, factor
    integer :: i, s
    allocate (lines%angular_frequency(modes), lines%frequency_deviation(modes), lines%decay_rate(modes), source=0.0_dp)
    allocate (lines%amplitude(size(facts%position), modes))
    allocate (lines%deviation(size(facts%position), modes), source=0.0_dp)
    allocate (truth%wavenumber(modes), truth%phase_velocity(modes), truth%group_velocity(modes))
    do i = 1, modes
      alpha = root_of(facts%ends, mass_ratio, i)
      k = alpha/length
      beta = sqrt(stiffness_root**2*k**4 - merge(turning**2, 0.0_dp, facts%rotates))
      truth%wavenumber(i) = real(k, dp)
      truth%phase_velocity(i) = real(beta/k, dp)
      truth%group_velocity(i) = real(2*stiffness_root**2*k**3/beta, dp)
      lines%decay_rate(i) = real(0.01_qp*beta, dp)
      lines%angular_frequency(i) = real(sqrt(beta**2 - lines%decay_rate(i)**2), dp)
      pole = cmplx(-lines%decay_rate(i), lines%angular_frequency(i), qp)
      factor = exp(cmplx(0.0_qp, 1.0_qp + i**2, qp))/i**2
      do s = 1, size(facts%position)
        lines%amplitude(s, i) = cmplx(factor*shape_of(facts%ends, alpha, real(facts%position(s), qp), &
          & facts%quantity(s)%text == 'strain')*unit_of(facts%quantity(s)%text, pole), kind=dp)
      end do
    end do
  end subroutine beam_lines

  pure complex(qp) function unit_of(quantity, pole)
    !! A quantity over displacement; the constant of strain is any.
    character(*), intent(in) :: quantity
    complex(qp), intent(in) :: pole
    select case (quantity)
    case ('velocity')
      unit_of = pole
    case ('acceleration')
      unit_of = pole**2
    case ('strain')
      unit_of = 0.0037_qp
    case default
      unit_of = 1
    end select
  end function unit_of

  pure real(qp) function root_of(ends, mass_ratio, mode) result(alpha)
    !! α of a mode by bisection of its frequency equation.
    character(*), intent(in) :: ends
    real(dp), intent(in) :: mass_ratio
    integer, intent(in) :: mode
    real(qp) :: low, high
    integer :: i
    if (ends == 'tip') then
      low = merge(0.01_qp, (mode - 0.75_qp)*pi - 0.01_qp, mode == 1)
      high = merge(1.9_qp, (mode - 0.5_qp)*pi + 0.02_qp, mode == 1)
    else
      low = mode*pi
      high = (mode + 1)*pi
    end if
    do i = 1, 120
      alpha = (low + high)/2
      if (equation(alpha) > 0 .eqv. equation(low) > 0) then
        low = alpha
      else
        high = alpha
      end if
    end do

  contains

    pure real(qp) function equation(a)
      !! Eq. 19 over cosh α, or that of two clamped or two free ends.
      real(qp), intent(in) :: a
      if (ends == 'tip') then
        equation = 1/cosh(a) + cos(a) + a*mass_ratio*(cos(a)*tanh(a) - sin(a))
      else
        equation = cos(a) - 1/cosh(a)
      end if
    end function equation

  end function root_of

  pure real(qp) function shape_of(ends, alpha, xi, strain) result(shape)
    !! The mode's shape, or its second derivative over α², of size 1.
    character(*), intent(in) :: ends
    real(qp), intent(in) :: alpha, xi
    logical, intent(in) :: strain
    real(qp) :: sigma, bend, z
    z = alpha*xi
    bend = merge(-1, 1, strain)
    select case (ends)
    case ('tip')
      sigma = (cos(alpha) + cosh(alpha))/(sin(alpha) + sinh(alpha))
      shape = bend*cos(z) - cosh(z) - sigma*(bend*sin(z) - sinh(z))
    case ('clamped')
      sigma = (cos(alpha) - cosh(alpha))/(sin(alpha) - sinh(alpha))
      shape = bend*cos(z) - cosh(z) - sigma*(bend*sin(z) - sinh(z))
    case default
      sigma = (cos(alpha) - cosh(alpha))/(sin(alpha) - sinh(alpha))
      shape = bend*cos(z) + cosh(z) - sigma*(bend*sin(z) + sinh(z))
    end select
  end function shape_of

  subroutine noisy(clean, noise, known, lines, share)
    !! Add normal noise, a part of each line's root mean square over the sensors of the same unit; frequencies get a hundredth.
    !! Sensors may share a part of its variance.
    type(measured_lines), intent(in) :: clean
    real(dp), intent(in) :: noise(:, :)        !! standard deviation of real and imaginary part, (sensor, line)
    logical, intent(in) :: known               !! it is told
    type(measured_lines), intent(out) :: lines
    real(dp), intent(in), optional :: share
    complex(dp) :: common
    integer :: i, k, s
    lines = clean
    if (present(share)) lines%correlation = reshape([(((cmplx(merge(1.0_dp, share, s == i), 0, dp), s=1, size(noise, 1)), &
      & i=1, size(noise, 1)), k=1, size(noise, 2))], [size(noise, 1), size(noise, 1), size(noise, 2)])
    if (known) lines%deviation = noise
    do k = 1, size(noise, 2)
      common = normal_pair()
      do s = 1, size(noise, 1)
        if (present(share)) then
          lines%amplitude(s, k) = lines%amplitude(s, k) + noise(s, k)*(sqrt(share)*common + sqrt(1 - share)*normal_pair())
        else
          lines%amplitude(s, k) = lines%amplitude(s, k) + noise(s, k)*normal_pair()
        end if
      end do
      lines%frequency_deviation(k) = 1.0e-5_dp*lines%angular_frequency(k)
      lines%angular_frequency(k) = lines%angular_frequency(k) + lines%frequency_deviation(k)*real(normal_pair())
    end do
  end subroutine noisy

  complex(dp) function normal_pair()
    !! Two normal numbers. (One at a time would be one and the same where two stand in an expression: compilers may call a
    !! function once for both.)
    real(dp) :: one, other
    call random_number(one)
    call random_number(other)
    normal_pair = sqrt(-2*log(1 - one))*exp(cmplx(0.0_dp, 2*pi*other, dp))
  end function normal_pair

  function judge(facts, mass_ratio, modes, decibels, draws, share) result(tally)
    !! Draw beams with noise, and count.
    type(sensor_facts), intent(in) :: facts
    real(dp), intent(in) :: mass_ratio
    integer, intent(in) :: modes
    real(dp), intent(in) :: decibels           !! of each line's root mean square at the sensors, over the noise
    integer, intent(in) :: draws
    real(dp), intent(in), optional :: share    !! of the noise's variance, that all sensors have in common
    type(tally_type) :: tally
    type(measured_lines) :: clean, lines
    type(truth_type) :: truth
    type(sensor_waves) :: waves
    real(dp), allocatable :: noise(:, :)
    integer :: i, k
    call beam_lines(facts, mass_ratio, modes, clean, truth)
    allocate (noise(size(facts%position), modes))
    do k = 1, modes
      noise(:, k) = 10**(-decibels/20)*[(sqrt(sum(abs(clean%amplitude(:, k))**2, mask=same_unit(i)) &
        & /count(same_unit(i))), i=1, size(noise, 1))]
    end do
    do i = 1, draws
      call noisy(clean, noise, .true., lines, share)
      call measure_sensor_waves(facts, lines, waves)
      call add_to(tally, truth, waves, facts%rotates)
    end do

  contains

    function same_unit(s)
      !! Which sensors measure what sensor s does.
      integer, intent(in) :: s
      logical :: same_unit(size(facts%position))
      integer :: j
      same_unit = [(facts%quantity(j)%text == facts%quantity(s)%text, j=1, size(facts%position))]
    end function same_unit

  end function judge

  subroutine add_to(tally, truth, waves, rotates)
    !! Count what one draw shows.
    type(tally_type), intent(inout) :: tally
    type(truth_type), intent(in) :: truth
    type(sensor_waves), intent(in) :: waves
    logical, intent(in) :: rotates
    integer :: i
    tally%lines = tally%lines + size(truth%wavenumber)
    tally%given = tally%given + count(.not. is_missing(waves%wavenumber))
    tally%groups = tally%groups + count(.not. is_missing(waves%group_velocity))
    tally%held(1) = tally%held(1) + held(waves%wavenumber, waves%wavenumber_error, truth%wavenumber)
    tally%held(2) = tally%held(2) + held(waves%phase_velocity, waves%phase_velocity_error, truth%phase_velocity)
    tally%held(3) = tally%held(3) + held(waves%group_velocity, waves%group_velocity_error, truth%group_velocity)
    tally%aliases = tally%aliases + count(.not. is_missing(waves%wavenumber)) &
      & - held(waves%wavenumber, 3*waves%wavenumber_error, truth%wavenumber)
    tally%noted = tally%noted + count([(index(waves%notes(i)%text, 'these shapes differ') > 0, i=1, size(waves%notes))])
    if (is_missing(waves%stiffness_root)) return
    tally%dispersions(1) = tally%dispersions(1) + 1
    tally%dispersions_held(1) = tally%dispersions_held(1) &
      & + held([waves%stiffness_root], [waves%stiffness_root_error], [stiffness_root])
    if (.not. rotates) return
    tally%dispersions(2) = tally%dispersions(2) + 1
    tally%dispersions_held(2) = tally%dispersions_held(2) &
      & + held([waves%angular_velocity], [waves%angular_velocity_error], [turning])
  end subroutine add_to

  pure integer function held(value, error, true)
    !! How many values have the true ones inside their intervals.
    real(dp), intent(in) :: value(:), error(:), true(:)
    held = count(abs(value - true) <= error .and. .not. is_missing(value))
  end function held

end module wave_draws
