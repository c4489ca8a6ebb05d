module bw_hammer
  !! A blow whose force is measured. After it the beam moves as Σ Re A e^(zt), with A = C F/(iβ), times z for each derivative that
  !! a sensor measures. Here z = −δ + iβ, F = ∫f e^(−zt)dt, and C = φ_sφ_f/M is the modal constant, in 1/kg. This holds for any
  !! shape of the blow and any number of hits.
  use bw_kinds, only: dp
  use bw_order, only: quantile_of
  implicit none (type, external)
  private
  public :: find_constants, hammer_of

  real(dp), parameter :: clear = 0.1_dp          !! of the largest force, above which there is a blow
  real(dp), parameter :: seen = 4                !! standard deviations of the force at rest, above which a blow continues
  real(dp), parameter :: soon = 1.0_dp/16        !! of the record: the longest time between two hits that are one blow
  real(dp), parameter :: normal_median = 0.6745_dp   !! median of the absolute value of a standard normal number

  type, public :: hammer_type
    real(dp), allocatable :: force(:)            !! N, 0 where the hammer does not touch the beam, (samples)
    logical, allocatable :: acts(:)              !! during a blow, (samples)
    integer, allocatable :: after(:)             !! the first sample after each blow, (blows)
    integer, allocatable :: unseen(:)            !! sensors with invalid samples during a blow
    real(dp) :: deviation = 0                    !! standard deviation of the force at rest, N
  end type hammer_type

contains

  pure type(hammer_type) function hammer_of(force) result(hammer)
    !! Find the blows in a force: each begins where the force is clearly above its value at rest, and extends both ways as long
    !! as it exceeds noise. Hits in quick succession are one blow.
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
    allocate (hammer%unseen(0))
    last = n
    do j = 1, n
      if (.not. hammer%acts(j)) cycle
      if (j > last + 1 .and. j - last <= soon*n) hammer%acts(last:j) = .true.
      last = j
    end do
    hammer%after = pack([(j, j=2, n)], hammer%acts(:n - 1) .and. .not. hammer%acts(2:))
  end function hammer_of

  pure subroutine find_constants(hammer, step, row, pole, derivative, amplitude, constant, share)
    !! Find the modal constants of a line at some sensors, from the first blow.
    type(hammer_type), intent(in) :: hammer
    real(dp), intent(in) :: step                 !! s
    integer, intent(in) :: row                   !! the sample that the amplitudes refer to
    complex(dp), intent(in) :: pole              !! −δ + iβ, rad/s
    integer, intent(in) :: derivative(:)         !! 0 for displacement, 1 for velocity, 2 for acceleration, (sensors)
    complex(dp), intent(in) :: amplitude(:)      !! in SI, (sensors)
    complex(dp), intent(out) :: constant(:)      !! 1/kg, (sensors)
    real(dp), intent(out) :: share               !! relative standard deviation of the constants due to noise of the force
    complex(dp) :: turn(hammer%after(1)), impulse
    integer :: j
    turn = [(exp(-pole*step*(j - row)), j=1, size(turn))]
    impulse = step*sum(turn*hammer%force(:size(turn)))
    constant = amplitude*cmplx(0, pole%im, dp)/impulse/pole**derivative
    share = step*hammer%deviation*norm2(abs(pack(turn, hammer%acts(:size(turn)))))/abs(impulse)
  end subroutine find_constants

end module bw_hammer
