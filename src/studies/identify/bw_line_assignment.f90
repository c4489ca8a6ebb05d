module bw_line_assignment
  !! Assignment of measured lines to modes of least penalty: both keep their ascending order, and spurious lines and
  !! undetected modes are left out.
  !!
  !! A penalty is −2 ln of a probability. A line is a mode with probability 1 − p, where p is its `chance` to be spurious, and
  !! then is normally distributed about the mode's frequency f with relative variance s² + τ²: the line's own variance s², and
  !! τ² of the model, common to all lines. A spurious line is uniformly distributed over the logarithm of the band's
  !! frequencies. Any mode below the last one with a line is undetected with probability `p_undetected`. So a pair costs
  !! ((f_line − f)/f_line)²/(s² + τ²) + ρ ln 2π(s² + τ²) − 2 ln (1 − p)(1 − p_undetected), a spurious line 2ρ ln(width of the
  !! band) − 2 ln p, and an undetected mode −2 ln p_undetected. As k unknowns make k of n residuals vanish for any lines, the
  !! logarithms count by ρ = 1 − k/n only, as in restricted likelihood.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: assign, best_scatter

  real(dp), parameter :: p_undetected = 0.3_dp       !! chosen: many modes are undetected

  type, public :: frequency_band
    !! Parameters of penalties common to all lines and modes.
    real(dp) :: width = 1.0_dp           !! ln of the highest over the lowest frequency that a line may have
    real(dp) :: share = 1.0_dp           !! ρ
  end type frequency_band

  type, public :: pairing
    !! The lines and modes of one record.
    real(dp), allocatable :: line(:)     !! frequencies, ascending, > 0, (lines)
    real(dp), allocatable :: deviation(:)  !! relative standard deviations s, (lines)
    logical, allocatable :: spurious(:)   !! a line known to be no mode, (lines)
    real(dp), allocatable :: chance(:)   !! probability that a line is spurious, regardless of its frequency, (lines)
    real(dp), allocatable :: mode(:)     !! frequencies, ascending; not > 0: assigned to no line, (modes)
    integer, allocatable :: mode_of(:)   !! the mode of each line; 0: none, (lines)
  end type pairing

contains

  subroutine best_scatter(records, band, least, scatter, penalty)
    !! Assign the lines of several records with the τ of least penalty.
    type(pairing), intent(inout) :: records(:)
    type(frequency_band), intent(in) :: band
    real(dp), intent(in) :: least        !! lower bound of τ
    real(dp), intent(out) :: scatter     !! τ
    real(dp), intent(out) :: penalty
    real(dp), parameter :: largest = 0.3_dp, ratio = 2.0_dp
    integer, parameter :: most = 22      !! values of τ: down to 1e-7 of the largest, then 0
    real(dp) :: tau, cost
    integer :: i
    penalty = huge(penalty)
    scatter = largest
    do i = 0, most
      tau = largest/ratio**i
      if (i == most) tau = 0
      if (tau < least) tau = least
      call add_penalties(tau, cost)
      if (cost < penalty) scatter = tau
      penalty = min(penalty, cost)
      if (tau <= least) exit
    end do
    call add_penalties(scatter, penalty)
  contains
    subroutine add_penalties(tau, total)
      real(dp), intent(in) :: tau
      real(dp), intent(out) :: total
      real(dp) :: one
      integer :: r
      total = 0
      do r = 1, size(records)
        call assign(records(r), band, tau, one)
        total = total + one
      end do
    end subroutine add_penalties
  end subroutine best_scatter

  pure subroutine assign(record, band, tau, penalty)
    !! Find the assignment of least penalty, by dynamic programming over the first i lines and j modes.
    type(pairing), intent(inout) :: record
    type(frequency_band), intent(in) :: band
    real(dp), intent(in) :: tau
    real(dp), intent(out) :: penalty
    integer, parameter :: pair = 1, spurious = 2, undetected = 3
    real(dp), allocatable :: cost(:, :)
    integer, allocatable :: step(:, :)
    real(dp) :: choices(3)
    integer :: i, j, n, m
    n = size(record%line)
    m = size(record%mode)
    allocate (cost(0:n, 0:m), step(0:n, 0:m))
    step = 0
    cost(0, 0) = 0
    do j = 0, m
      do i = 0, n
        if (i + j == 0) cycle
        choices = huge(penalty)
        if (i > 0 .and. j > 0) choices(pair) = cost(i - 1, j - 1) + pair_penalty(record, band, tau, i, j)
        if (i > 0) choices(spurious) = cost(i - 1, j) + 2*band%share*log(band%width) - 2*log(record%chance(i))
        if (j > 0) choices(undetected) = cost(i, j - 1) + merge(-2*log(p_undetected), 0.0_dp, record%mode(j) > 0)
        step(i, j) = minloc(choices, dim=1)
        cost(i, j) = choices(step(i, j))
      end do
    end do
    if (allocated(record%mode_of)) deallocate (record%mode_of)
    allocate (record%mode_of(n), source=0)
    i = n
    j = minloc(cost(n, :), dim=1) - 1                  ! undetected modes above the last with a line cost nothing
    penalty = cost(n, j)
    do while (i + j > 0)
      if (step(i, j) == pair) record%mode_of(i) = j
      select case (step(i, j))
      case (pair)
        i = i - 1
        j = j - 1
      case (spurious)
        i = i - 1
      case default
        j = j - 1
      end select
    end do
  end subroutine assign

  pure real(dp) function pair_penalty(record, band, tau, i, j) result(penalty)
    !! Return the penalty of line i as mode j.
    type(pairing), intent(in) :: record
    type(frequency_band), intent(in) :: band
    real(dp), intent(in) :: tau
    integer, intent(in) :: i, j
    real(dp), parameter :: never = 1.0e30_dp
    real(dp) :: variance
    penalty = never
    if (record%spurious(i) .or. .not. record%mode(j) > 0) return
    variance = record%deviation(i)**2 + tau**2
    penalty = min(never, ((record%line(i) - record%mode(j))/record%line(i))**2/variance) &
      + band%share*log(2*pi*variance) - 2*log((1 - record%chance(i))*(1 - p_undetected))
  end function pair_penalty

end module bw_line_assignment
