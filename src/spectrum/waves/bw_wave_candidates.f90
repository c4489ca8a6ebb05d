module bw_wave_candidates
  !! The candidates for the lines' wave numbers, as points (β², α⁴), which for a uniform beam lie on a straight line (Eq. 3), and
  !! with a mass at the tip as angles of the mass that each implies (Eq. 19).
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_shape_fit, only: wave_candidate, worse
  use bw_tip_mass, only: alpha_range, mass_angle, mode_near
  implicit none (type, external)
  private
  public :: possible_tips, problem_of

  real(dp), parameter :: first = 3             !! largest α of a first mode; the deviation of a smaller α may reach up to it

  type, public :: choice_type
    !! The candidates for the wave number of one line.
    type(wave_candidate), allocatable :: candidates(:)
    real(dp) :: scale = 1                      !! standard deviation of the data relative to the given one
    integer :: freedom = huge(1)               !! degrees of freedom of the scale
    logical :: misfits = .false.               !! the shape does not fit, and the scale is estimated from the misfit
    integer :: chosen = 0                      !! index of the chosen candidate; 0: none
    integer :: rival = 0                       !! the next best after `best`
    integer :: best = 0
    logical :: on_curve = .false.              !! it lies on the common curve of the lines
  end type choice_type

  type, public :: problem_type
    !! All lines and their candidates in the form that the search uses.
    real(dp), allocatable :: square(:)         !! β² relative to the largest, (line)
    real(dp), allocatable :: power(:, :), variance(:, :)  !! α⁴ and its variance, (candidate, line)
    real(dp), allocatable :: cost(:, :)        !! misfit above the smallest, (candidate, line)
    real(dp), allocatable :: angle(:, :), angle_variance(:, :)  !! of the implied mass
    integer, allocatable :: mode(:, :)         !! mode number, with a mass at the tip; otherwise approximate
    integer, allocatable :: count(:)           !! number of candidates, (line)
    logical :: rotates = .false., tip = .false.
  end type problem_type

contains

  pure function possible_tips(candidates) result(possible)
    !! The candidates that a mass at the tip allows within five standard deviations: α between those of infinite mass and of none.
    type(wave_candidate), intent(in) :: candidates(:)
    type(wave_candidate), allocatable :: possible(:)
    logical :: allowed(size(candidates))
    real(dp) :: range(2)
    integer :: i
    do i = 1, size(candidates)
      range = alpha_range(mode_near(candidates(i)%alpha))
      associate (alpha => candidates(i)%alpha, reach => sqrt(worse)*min(candidates(i)%deviation, 1.0_dp))
        allowed(i) = alpha >= range(1) - reach .and. alpha <= range(2) + reach
      end associate
    end do
    possible = pack(candidates, allowed)
  end function possible_tips

  pure type(problem_type) function problem_of(square, rotates, tip, choices) result(problem)
    !! The candidates as points (β², α⁴), with their variances.
    real(dp), intent(in) :: square(:)
    logical, intent(in) :: rotates, tip
    type(choice_type), intent(in) :: choices(:)
    real(dp) :: deviation, step
    integer :: j, k, most
    most = maxval([(size(choices(k)%candidates), k=1, size(choices))])
    problem%count = [(size(choices(k)%candidates), k=1, size(choices))]
    problem%square = square/maxval(square)
    problem%rotates = rotates .and. count(problem%count > 0) > 1
    problem%tip = tip
    allocate (problem%power(most, size(square)), problem%variance(most, size(square)), problem%cost(most, size(square)), &
      & problem%angle(most, size(square)), problem%angle_variance(most, size(square)), source=huge(1.0_dp))
    allocate (problem%mode(most, size(square)), source=0)
    do k = 1, size(square)
      associate (candidates => choices(k)%candidates)
        do j = 1, size(candidates)
          deviation = min(candidates(j)%deviation, max(1.0_dp, first - candidates(j)%alpha)) + 1.0e-9_dp*candidates(j)%alpha
          problem%power(j, k) = candidates(j)%alpha**4
          problem%variance(j, k) = ((candidates(j)%alpha + deviation)**4 - candidates(j)%alpha**4)**2
          problem%cost(j, k) = candidates(j)%cost
          problem%mode(j, k) = floor(candidates(j)%alpha/pi)
          if (.not. tip) cycle
          problem%mode(j, k) = mode_near(candidates(j)%alpha)
          problem%angle(j, k) = mass_angle(candidates(j)%alpha, problem%mode(j, k))
          step = min(deviation, candidates(j)%alpha/2)
          problem%angle_variance(j, k) = (problem%angle(j, k) - mass_angle(candidates(j)%alpha - step, problem%mode(j, k)))**2
        end do
      end associate
    end do
  end function problem_of

end module bw_wave_candidates
