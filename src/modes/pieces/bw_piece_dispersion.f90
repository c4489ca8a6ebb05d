module bw_piece_dispersion
  !! The waves of a beam of pieces as a function of frequency: the mean wave number of bending waves, and the number of
  !! half waves in the beam, which is near the number of modes below.
  !!
  !! z = p² solves Bz² − (R + σB)z − mλ(1 − sR) = 0, which also gives dz/dβ².
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_double_double, only: to_dd
  use bw_piece_beam, only: piece_beam
  use bw_piece_waves, only: frequency_at, piece_frequency, piece_numbers
  implicit none (type, external)
  private
  public :: next_half_wave, mean_waves


contains

  pure real(dp) function next_half_wave(beam, piece, start, more) result(x)
    !! Estimate λ at which the beam holds `more` further half waves.
    type(piece_beam), intent(in) :: beam
    type(piece_numbers), intent(in) :: piece(:)
    real(dp), intent(in) :: start                       !! λ ≥ 0
    real(dp), intent(in) :: more                        !! may be negative
    real(dp), parameter :: near_enough = 0.05_dp, longest = 4.0_dp, least = 0.25_dp, far = 100.0_dp
    integer, parameter :: most = 30
    real(dp) :: number, waves, slope
    integer :: i
    call half_waves(piece, frequency_at(beam, to_dd(start), rough=.true.), waves, slope)
    if (start > 0.0_dp) then
      x = start
      number = max(least*waves, waves + more)
    else
      x = 1.0_dp
      number = waves + more - 0.5_dp                    ! a clamped root takes half of one
    end if
    do i = 1, most
      if (i > 1 .or. x > start) call half_waves(piece, frequency_at(beam, to_dd(x), rough=.true.), waves, slope)
      if (abs(waves - number) < near_enough) return
      if (waves > far*number) then
        x = x*exp(log(number/waves)*(waves/(slope*x)))         ! their number is roughly a power of λ
      else
        x = x*exp(max(-longest, min(longest, (number - waves)/(slope*x))))
      end if
    end do
  end function next_half_wave

  pure subroutine half_waves(piece, frequency, number, slope)
    !! Find the half waves of all propagating waves, and approximately their derivative by β², as if all grew at the
    !! rate of bending waves: thickness-shear waves, with infinite slope at cutoff, soon do.
    type(piece_numbers), intent(in) :: piece(:)
    type(piece_frequency), intent(in) :: frequency      !! λ > 0
    real(dp), intent(out) :: number, slope
    real(dp) :: p(2), rise(2), bending
    integer :: i
    number = 0.0_dp
    slope = 0.0_dp
    bending = 0.0_dp
    do i = 1, size(piece)
      call local_waves(piece(i), frequency, p, rise)
      number = number + 2.0_dp*piece(i)%half%hi*sum(p)/pi
      bending = bending + 2.0_dp*piece(i)%half%hi*p(1)/pi
      slope = slope + 2.0_dp*piece(i)%half%hi*rise(1)/pi
    end do
    if (bending > 0.0_dp) slope = slope*(number/bending)
  end subroutine half_waves

  pure subroutine mean_waves(piece, frequency, alpha, phase_velocity, group_velocity)
    !! Find P, the mean wave number of bending waves, β/P and dβ/dP; missing if they do not exist.
    type(piece_numbers), intent(in) :: piece(:)
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(out) :: alpha, phase_velocity, group_velocity
    real(dp) :: p(2), rise(2), slope
    integer :: i
    alpha = 0.0_dp
    slope = 0.0_dp
    do i = 1, size(piece)
      call local_waves(piece(i), frequency, p, rise)
      alpha = alpha + 2.0_dp*piece(i)%half%hi*p(1)
      slope = slope + 2.0_dp*piece(i)%half%hi*rise(1)
    end do
    phase_velocity = missing
    group_velocity = missing
    associate (square => frequency%beta_squared%hi)
      if (square >= 0.0_dp .and. alpha > 0.0_dp) phase_velocity = sqrt(square)/alpha
      if (square > 0.0_dp .and. slope > 0.0_dp) group_velocity = 0.5_dp/(sqrt(square)*slope)
    end associate
  end subroutine mean_waves

  pure subroutine local_waves(piece, frequency, p, rise)
    !! Find wave numbers of the bending and the thickness-shear wave, and their derivatives by β²; 0 if there is none.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(out) :: p(2), rise(2)
    real(dp) :: u, r, sigma, cutoff, root, z(2), y
    integer :: i
    p = 0.0_dp
    rise = 0.0_dp
    u = piece%wave%hi*frequency%lambda%hi
    if (piece%plain) then
      if (u <= 0.0_dp) return
      p(1) = sqrt(sqrt(u))
      rise(1) = 0.25_dp*p(1)/frequency%lambda%hi
      return
    end if
    r = piece%turn%hi*frequency%rho%hi
    sigma = piece%shear%hi*frequency%lambda%hi
    cutoff = 1.0_dp - piece%cut%hi*frequency%rho%hi
    root = (r - sigma)**2 + 4.0_dp*u
    if (root <= 0.0_dp) return                          ! λ < 0: all waves decay
    root = sqrt(root)
    if (r >= sigma) then
      y = 0.5_dp*((r - sigma) + root)
    else
      y = 2.0_dp*u/(root + (sigma - r))
    end if
    z(1) = y + sigma
    z(2) = 0.0_dp
    if (z(1) > 0.0_dp) z(2) = -u*cutoff/z(1)
    do i = 1, 2
      if (z(i) <= 0.0_dp) cycle
      p(i) = sqrt(z(i))
      rise(i) = (piece%turn%hi + piece%shear%hi)*z(i) + piece%wave%hi*(cutoff - frequency%lambda%hi*piece%cut%hi)
      rise(i) = merge(rise(i), -rise(i), i == 1)/(2.0_dp*p(i)*root)
    end do
  end subroutine local_waves

end module bw_piece_dispersion
