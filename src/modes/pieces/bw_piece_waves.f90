module bw_piece_waves
  !! The waves that a uniform piece carries at a frequency.
  !!
  !! With λ = β² (+ Ω² in plane) for translations and ρ = β² (+ Ω² out of plane) for rotations of sections, e^(ipx)
  !! satisfies the equations of a piece for two values of z = p²: z = y + σ, By² − (R − Bσ)y − mλ = 0, σ = smλ, R = ρI
  !! ρ. z₁ > 0 always; z₂ < 0, a pair of exponentials, up to the cutoff sR = 1, where z₁z₂ = −mλ(1 − sR)/B changes sign.
  !! Without shear y = z = ±√(mλ/B).
  !!
  !! With C = cos √z x and S = sin √z x/√z, x from the middle of the piece, v = C is the even solution of a wave and v =
  !! zS the odd one. Phases are reduced by quarter cycles in double-double before rounding, so sines and cosines are as
  !! accurate in mode 10⁵ as in mode 1.
  use bw_double_double, only: dd, dd_pi, sqrt, to_dd, operator(+), operator(-), operator(*), operator(/)
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam, uniform_piece
  implicit none (type, external)
  private
  public :: frequency_at, numbers_of, find_waves, wave_numbers_of, is_short, parts_at_rest, circular

  real(dp), parameter :: short_square = 0.5_dp
    !! |z|h² up to which a piece is short: half of it changes no phase by more than 0.7 rad
  real(dp), parameter :: most_quarters = 1.0e8_dp
    !! limit of quarter cycles counted in half a piece: more modes than ever needed lie below

  type, public :: piece_frequency
    type(dd) :: lambda                   !! λ
    type(dd) :: rho                      !! ρ
    type(dd) :: beta_squared             !! β²
    type(dd) :: fourth_root              !! λ^¼, for λ > 0, unless all pieces have shear
    real(dp) :: unit(4) = 1.0_dp         !! v, ψ, M and N of a typical motion of the beam
    logical :: rough = .false.           !! binary64 wave numbers suffice, for searches and counts
  end type piece_frequency

  type, public :: piece_numbers
    !! Wave parameters of a piece.
    type(dd) :: half                     !! h, half its length
    type(dd) :: wave                     !! m/B
    type(dd) :: shear                    !! sm
    type(dd) :: turn                     !! ρI/B
    type(dd) :: cut                      !! sρI
    type(dd) :: angle                    !! (m/B)^¼ h
    type(dd) :: flexible                 !! sB
    type(dd) :: stiffness                !! B
    type(dd) :: mass                     !! m
    type(dd) :: rotary                   !! ρI
    logical :: plain = .true.            !! neither shear nor rotary inertia
  end type piece_numbers

  type, public :: wave_numbers
    !! Wave numbers of the two waves.
    type(dd) :: y(2)
    type(dd) :: z(2)
    type(dd) :: p(2)                     !! √|z|
  end type wave_numbers

  type, public :: piece_waves
    logical :: short = .false.           !! a power series is used instead, and nothing else is set
    real(dp) :: y(2) = 0.0_dp
    real(dp) :: z(2) = 0.0_dp
    real(dp) :: c(2) = 0.0_dp            !! C at the end; over cosh √(−z)h for z < 0
    real(dp) :: s(2) = 0.0_dp            !! S likewise
    real(dp) :: w(2) = 1.0_dp            !! C² + zS² of these: 1, or 1/cosh² √(−z)h
    integer :: quarters = 0              !! whole quarter cycles of propagating waves over half of the piece
  end type piece_waves

contains

  elemental type(piece_numbers) function numbers_of(piece) result(numbers)
    type(uniform_piece), intent(in) :: piece
    numbers%half = piece%length*0.5_dp
    numbers%wave = piece%mass/piece%stiffness
    numbers%shear = piece%compliance*piece%mass
    numbers%turn = piece%rotary/piece%stiffness
    numbers%cut = piece%compliance*piece%rotary
    numbers%angle = sqrt(sqrt(numbers%wave))*numbers%half
    numbers%flexible = piece%compliance*piece%stiffness
    numbers%stiffness = piece%stiffness
    numbers%mass = piece%mass
    numbers%rotary = piece%rotary
    numbers%plain = .not. (piece%compliance%hi > 0.0_dp .or. piece%rotary%hi > 0.0_dp)
  end function numbers_of

  pure type(piece_frequency) function frequency_at(beam, lambda, rough) result(frequency)
    type(piece_beam), intent(in) :: beam
    type(dd), intent(in) :: lambda
    logical, intent(in), optional :: rough       !! absent: false
    if (present(rough)) frequency%rough = rough
    frequency%lambda = lambda
    if (beam%in_plane) then
      frequency%beta_squared = lambda - beam%spin_squared
      frequency%rho = frequency%beta_squared
    else
      frequency%beta_squared = lambda
      frequency%rho = lambda + beam%spin_squared
    end if
    if (lambda%hi > 0.0_dp) then
      if (frequency%rough) then
        frequency%fourth_root = to_dd(sqrt(sqrt(lambda%hi)))
      else if (.not. all(beam%piece%compliance%hi > 0.0_dp)) then
        frequency%fourth_root = sqrt(sqrt(lambda))
      end if
    end if
    frequency%unit = units_at(beam, frequency)
  end function frequency_at

  pure function units_at(beam, frequency) result(unit)
    !! Return scales of v, ψ, M and N in a motion of the beam: a deflection of 1; the slope of waves, or of the whole beam if
    !! waves are longer; and the forces due to inertia, at most those of waves. Stiffness is that of all pieces in series.
    type(piece_beam), intent(in) :: beam
    type(piece_frequency), intent(in) :: frequency
    real(dp) :: unit(4)
    real(dp), parameter :: nothing = 1.0e-60_dp  ! force at λ = 0
    real(dp) :: stiffness, mass, kappa, force
    associate (piece => beam%piece, joint => beam%joint)
      stiffness = 1.0_dp/sum(piece%length%hi/piece%stiffness%hi)
      mass = sum(piece%length%hi*piece%mass%hi)*abs(frequency%lambda%hi)
      kappa = max(1.0_dp, sqrt(sqrt(mass/stiffness)))
      force = mass + sum(piece%length%hi*piece%rotary%hi)*abs(frequency%rho%hi) &
        + maxval(joint%mass%hi)*abs(frequency%lambda%hi) + maxval(joint%inertia%hi)*abs(frequency%beta_squared%hi)
      force = stiffness*max(nothing, min(1.0_dp, force/stiffness))
      unit = [1.0_dp, kappa, force*kappa**2, force*kappa**3/(1.0_dp + sum(piece%length%hi*piece%compliance%hi)*stiffness*kappa**2)]
    end associate
  end function units_at

  pure logical function is_short(piece, frequency)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    is_short = largest_square(piece, frequency)*piece%half%hi**2 <= short_square
  end function is_short

  pure real(dp) function largest_square(piece, frequency) result(bound)
    !! Bound |z|: roots of z² − bz + c, real or not.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp) :: b, c
    c = -piece%wave%hi*frequency%lambda%hi*(1.0_dp - piece%cut%hi*frequency%rho%hi)
    b = piece%turn%hi*frequency%rho%hi + piece%shear%hi*frequency%lambda%hi
    bound = 0.5_dp*abs(b) + sqrt(0.25_dp*b**2 + abs(c))
  end function largest_square

  pure function parts_at_rest(beam) result(parts)
    !! Return the number of parts that makes each piece short for −Ω² ≤ λ ≤ 0.
    type(piece_beam), intent(in) :: beam
    integer :: parts(size(beam%piece))
    real(dp), parameter :: most = 1.0e5_dp       ! so that parts of 10⁴ pieces can be counted
    real(dp) :: bending, shearing, spin, turning     ! wave numbers; none overflows
    integer :: i
    spin = sqrt(beam%spin_squared%hi)
    do i = 1, size(parts)
      associate (piece => beam%piece(i))
        turning = spin*sqrt(piece%rotary%hi/piece%stiffness%hi)
        shearing = spin*sqrt(piece%compliance%hi*piece%mass%hi)
        bending = sqrt(spin*sqrt(piece%mass%hi/piece%stiffness%hi)*hypot(1.0_dp, spin*sqrt(piece%compliance%hi*piece%rotary%hi)))
        parts(i) = ceiling(min(most, piece%length%hi*norm2([turning, shearing, bending])*sqrt(0.25_dp/short_square)*1.01_dp))
      end associate
    end do
    parts = max(parts, 1)
  end function parts_at_rest

  pure subroutine find_waves(piece, frequency, waves)
    !! Find the waves at λ > 0, or at any λ in a short piece.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    type(piece_waves), intent(out) :: waves
    type(wave_numbers) :: numbers
    type(dd) :: angle
    integer :: i, quarters
    waves%short = is_short(piece, frequency)
    if (waves%short) return
    if (piece%plain) then
      angle = piece%angle*frequency%fourth_root
      waves%y(1) = sqrt(piece%wave%hi*frequency%lambda%hi)
      waves%y(2) = -waves%y(1)
      waves%z = waves%y
      call find_circular(angle, angle%hi/piece%half%hi, waves%c(1), waves%s(1), waves%quarters)
      call find_exponential(piece%half%hi, angle%hi/piece%half%hi, waves%c(2), waves%s(2), waves%w(2))
      return
    end if
    if (frequency%rough) then
      numbers = rough_numbers(piece, frequency)
    else
      numbers = wave_numbers_of(piece, frequency)
    end if
    waves%y = numbers%y%hi
    waves%z = numbers%z%hi
    do i = 1, 2
      if (waves%z(i) < 0.0_dp) then
        call find_exponential(piece%half%hi, numbers%p(i)%hi, waves%c(i), waves%s(i), waves%w(i))
      else
        call find_circular(numbers%p(i)*piece%half, numbers%p(i)%hi, waves%c(i), waves%s(i), quarters)
        if (numbers%p(i)%hi == 0.0_dp) waves%s(i) = piece%half%hi
        waves%quarters = waves%quarters + quarters + (i - 1)     ! beyond the cutoff one mode more: ψ constant, v = 0
      end if
    end do
  end subroutine find_waves

  pure type(wave_numbers) function wave_numbers_of(piece, frequency) result(waves)
    !! Return the wave numbers for λ > 0.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    type(dd) :: u, sigma, difference, root
    if (piece%plain) then
      waves%p(1) = piece%angle*frequency%fourth_root/piece%half
      waves%p(2) = waves%p(1)
      waves%y(1) = waves%p(1)*waves%p(1)
      waves%y(2) = -waves%y(1)
      waves%z = waves%y
      return
    end if
    u = piece%wave*frequency%lambda
    sigma = piece%shear*frequency%lambda
    difference = piece%turn*frequency%rho - sigma
    root = sqrt(difference*difference + u*4.0_dp)
    if (difference%hi >= 0.0_dp) then
      waves%y(1) = (difference + root)*0.5_dp
      waves%y(2) = -(u/waves%y(1))
    else
      waves%y(2) = (difference - root)*0.5_dp
      waves%y(1) = -(u/waves%y(2))
    end if
    waves%z(1) = waves%y(1) + sigma
    waves%z(2) = (piece%cut*frequency%rho + (-1.0_dp))*u/waves%z(1)
    waves%p(1) = sqrt(waves%z(1))
    if (waves%z(2)%hi >= 0.0_dp) then
      waves%p(2) = sqrt(waves%z(2))
    else
      waves%p(2) = sqrt(-waves%z(2))
    end if
  end function wave_numbers_of

  pure type(wave_numbers) function rough_numbers(piece, frequency) result(waves)
    !! Return the same with shear in binary64.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp) :: u, sigma, difference, root
    u = piece%wave%hi*frequency%lambda%hi
    sigma = piece%shear%hi*frequency%lambda%hi
    difference = piece%turn%hi*frequency%rho%hi - sigma
    root = 0.5_dp*(abs(difference) + sqrt(difference**2 + 4.0_dp*u))
    if (difference >= 0.0_dp) then
      waves%y%hi = [root, -u/root]
    else
      waves%y%hi = [u/root, -root]
    end if
    waves%z(1)%hi = waves%y(1)%hi + sigma
    waves%z(2)%hi = (piece%cut%hi*frequency%rho%hi - 1.0_dp)*u/waves%z(1)%hi
    waves%p%hi = sqrt(abs(waves%z%hi))
  end function rough_numbers

  pure subroutine find_circular(angle, p, c, s, quarters)
    !! Find C and S of a propagating wave, and its whole quarter cycles.
    type(dd), intent(in) :: angle                !! ph ≥ 0
    real(dp), intent(in) :: p
    real(dp), intent(out) :: c, s
    integer, intent(out) :: quarters
    type(dd) :: rest
    real(dp) :: cosine, sine
    quarters = int(min(angle%hi*(2.0_dp/dd_pi%hi), most_quarters))
    rest = angle - dd_pi*(0.5_dp*quarters)
    cosine = cos(rest%hi) - rest%lo*sin(rest%hi)
    sine = sin(rest%hi) + rest%lo*cos(rest%hi)
    if (sine < 0.0_dp .or. cosine < 0.0_dp) then   ! the quotient was rounded across a quarter cycle
      quarters = quarters + merge(1, -1, cosine < 0.0_dp)
      rest%hi = sine
      sine = merge(-cosine, cosine, cosine < 0.0_dp)
      cosine = abs(rest%hi)
    end if
    select case (modulo(quarters, 4))
    case (0)
      c = cosine
      s = sine
    case (1)
      c = -sine
      s = cosine
    case (2)
      c = -cosine
      s = -sine
    case default
      c = sine
      s = -cosine
    end select
    s = s/max(p, tiny(p))
  end subroutine find_circular

  elemental subroutine circular(angle, cosine, sine)
    !! Compute cosine and sine of any angle.
    type(dd), intent(in) :: angle
    real(dp), intent(out) :: cosine, sine
    integer :: quarters
    if (angle%hi < 0.0_dp) then
      call find_circular(-angle, 1.0_dp, cosine, sine, quarters)
      sine = -sine
    else
      call find_circular(angle, 1.0_dp, cosine, sine, quarters)
    end if
  end subroutine circular

  elemental subroutine find_exponential(half, q, c, s, w)
    !! Find C and S over cosh qh of a pair of exponentials.
    real(dp), intent(in) :: half, q
    real(dp), intent(out) :: c, s, w
    real(dp), parameter :: nothing = 20.0_dp       ! qh above which tanh qh is 1
    real(dp), parameter :: little = 0.5_dp         ! qh below which 1 − e^(−2qh) loses digits
    real(dp) :: t, e
    c = 1.0_dp
    t = 1.0_dp
    w = 0.0_dp
    if (q*half < nothing) then
      e = exp(-2.0_dp*q*half)
      t = (1.0_dp - e)/(1.0_dp + e)
      if (q*half < little) t = tanh(q*half)
      w = 4.0_dp*e/(1.0_dp + e)**2
    end if
    s = t/q
  end subroutine find_exponential

end module bw_piece_waves
