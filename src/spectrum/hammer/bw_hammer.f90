module bw_hammer
  !! A blow whose force is measured. Behind it the beam moves as Σ Re A e^(zt), with A = C F/(iβ) times z for each derivative that a
  !! sensor measures: F = ∫f e^(−zt)dt, and C = φ_sφ_f/M is the modal constant, in 1/kg. With z = −δ + iβ this holds whatever the
  !! blow's shape and however often the hammer hits.
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_order, only: quantile_of
  implicit none (type, external)
  private
  public :: find_constants, hammer_of, hammer_response

  real(dp), parameter :: clear = 0.1_dp          !! of the largest force: what is more is a blow
  real(dp), parameter :: seen = 4                !! standard deviations of the force at rest: what is less is not the blow's any more
  real(dp), parameter :: soon = 1.0_dp/16        !! of the record: too short a decay between two hits to tell lines
  real(dp), parameter :: normal_median = 0.6745_dp   !! of a normal number's size

  type, public :: hammer_type
    real(dp), allocatable :: force(:)            !! N, 0 where the hammer does not touch the beam, (samples)
    logical, allocatable :: acts(:)              !! a blow is under way, (samples)
    integer, allocatable :: after(:)             !! the first sample behind each blow, (blows)
    real(dp) :: deviation = 0                    !! of the force at rest, N
  end type hammer_type

contains

  pure type(hammer_type) function hammer_of(force) result(hammer)
    !! The blows in a force: where it is clearly above that at rest, and outwards as long as it can be told from it. Hits that follow
    !! each other soon are one blow.
    real(dp), intent(in) :: force(:)             !! N, with any offset
    real(dp) :: above(size(force))
    integer :: j, n, last
    n = size(force)
    above = force - quantile_of(force, 0.5_dp)
    above = above*sign(1.0_dp, above(maxloc(abs(above), dim=1)))
    hammer%deviation = quantile_of(abs(above), 0.5_dp)/normal_median
    hammer%acts = above > max(clear*maxval(above), seen*hammer%deviation)
    do j = 2, n
      hammer%acts(j) = hammer%acts(j) .or. (hammer%acts(j - 1) .and. above(j) > seen*hammer%deviation)
    end do
    do j = n - 1, 1, -1
      hammer%acts(j) = hammer%acts(j) .or. (hammer%acts(j + 1) .and. above(j) > seen*hammer%deviation)
    end do
    hammer%force = merge(force - quantile_of(force, 0.5_dp), 0.0_dp, hammer%acts)
    last = n
    do j = 1, n
      if (.not. hammer%acts(j)) cycle
      if (j > last + 1 .and. j - last <= soon*n) hammer%acts(last:j) = .true.
      last = j
    end do
    hammer%after = pack([(j, j=2, n)], hammer%acts(:n - 1) .and. .not. hammer%acts(2:))
  end function hammer_of

  pure subroutine find_constants(hammer, step, row, pole, derivative, amplitude, constant, share)
    !! The modal constants of a line at some sensors, by the first blow.
    type(hammer_type), intent(in) :: hammer
    real(dp), intent(in) :: step                 !! s
    integer, intent(in) :: row                   !! the sample whose amplitudes these are
    complex(dp), intent(in) :: pole              !! −δ + iβ, rad/s
    integer, intent(in) :: derivative(:)         !! 0 of displacement, 1 of velocity, 2 of acceleration, (sensors)
    complex(dp), intent(in) :: amplitude(:)      !! in SI, (sensors)
    complex(dp), intent(out) :: constant(:)      !! 1/kg, (sensors)
    real(dp), intent(out) :: share               !! standard deviation of the force's part in it, relatively
    complex(dp) :: turn(hammer%after(1)), impulse
    integer :: j
    turn = [(exp(-pole*step*(j - row)), j=1, size(turn))]
    impulse = step*sum(turn*hammer%force(:size(turn)))
    constant = amplitude*cmplx(0, pole%im, dp)/impulse/pole**derivative
    share = step*hammer%deviation*norm2(abs(pack(turn, hammer%acts(:size(turn)))))/abs(impulse)
  end subroutine find_constants

  subroutine hammer_response(hammer, step, values, frequency, response, spectrum)
    !! The transforms of sensors over that of the force at the bins that are nearest to some frequencies; 0 where the force has none.
    type(hammer_type), intent(in) :: hammer
    real(dp), intent(in) :: step                 !! s
    real(dp), intent(in) :: values(:, :)         !! (samples, sensors)
    real(dp), intent(in) :: frequency(:)         !! Hz
    complex(dp), intent(out) :: response(:, :)   !! (frequencies, sensors)
    real(dp), intent(out) :: spectrum(:)         !! |F|, N s, (frequencies)
    type(real_fourier) :: fourier
    complex(dp) :: force(size(frequency))
    integer :: bin(size(frequency)), s, n
    n = size(values, 1)
    bin = min(n/2, nint(frequency*n*step))
    call fourier%prepare(n)
    fourier%samples = hammer%force
    call fourier%transform()
    force = fourier%spectrum(bin)
    spectrum = step*abs(force)
    response = 0
    do s = 1, size(values, 2)
      fourier%samples = values(:, s) - sum(values(:, s))/n
      call fourier%transform()
      where (abs(force) > 0) response(:, s) = fourier%spectrum(bin)/force
    end do
  end subroutine hammer_response

end module bw_hammer
