module bw_wave_choice
  !! Which of the wave numbers that fit a line alike is the line's: those of all lines lie on one curve α⁴ = A β² + B of
  !! a uniform beam, A > 0 and B ≥ 0, which is 0 without rotation (Eq. 3); and with a mass at the tip all imply the same mass
  !! (Eq. 19). What is chosen fits much better than every choice that contradicts it; otherwise nothing is.
  use bw_kinds, only: dp
  use bw_tip_mass, only: alpha_range, mass_angle, mode_near
  use bw_shape_fit, only: candidate_type, worse
  implicit none (type, external)
  private
  public :: choose_waves, possible_tips

  real(dp), parameter :: first = 3             !! α of a first mode at most; what is known of it may be that alone
  integer, parameter :: most_anchors = 6       !! lines that a curve is begun with
  real(dp), parameter :: clear = 2*log(1.0e4_dp)  !! that much better than any contradiction
  real(dp), parameter :: gap_costs = 2*log(10.0_dp)  !! of a mode without a line, below the highest that has one

  type, public :: choice_type
    !! The wave numbers that one line may have.
    type(candidate_type), allocatable :: candidates(:)
    real(dp) :: scale = 1                      !! deviation of the data over what it was said to be
    integer :: freedom = huge(1)               !! degrees of freedom that tell the scale
    logical :: misfits = .false.               !! the shape does not fit, by which the scale is told
    integer :: chosen = 0                      !! of the candidates; 0: none
    integer :: rival = 0                       !! where none is chosen: the next best beside the first, `best`
    integer :: best = 0
    logical :: on_curve = .false.              !! it lies on the curve of all
  end type choice_type

  type :: problem_type
    !! All lines and their candidates as the search sees them.
    real(dp), allocatable :: square(:)         !! β² over the largest, (line)
    real(dp), allocatable :: power(:, :), variance(:, :)  !! α⁴ and its variance, (candidate, line)
    real(dp), allocatable :: cost(:, :)        !! misfit above the least, (candidate, line)
    real(dp), allocatable :: angle(:, :), angle_variance(:, :)  !! of the mass that is implied
    integer, allocatable :: mode(:, :)         !! its number, with a mass at the tip; else about its number
    integer, allocatable :: count(:)           !! of candidates, (line)
    logical :: rotates = .false., tip = .false.
  end type problem_type

  type :: curve_type
    !! α⁴ = sum(value·[β², 1]) with its covariance, and the mass so far.
    real(dp) :: value(2) = 0, covariance(2, 2) = 0
    real(dp) :: angle = 0, angle_variance = huge(1.0_dp)
    real(dp) :: cost = 0
  end type curve_type

contains

  pure function possible_tips(candidates) result(possible)
    !! Those candidates that a mass at the tip allows within five deviations: α between those of an infinite mass and of none.
    type(candidate_type), intent(in) :: candidates(:)
    type(candidate_type), allocatable :: possible(:)
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

  subroutine choose_waves(square, rotates, tip, alone, choices)
    !! Choose a candidate for each line, or name the two best where nothing tells.
    real(dp), intent(in) :: square(:)          !! β² of the undamped line, (line)
    logical, intent(in) :: rotates             !! in the plane of bending
    logical, intent(in) :: tip                 !! a mass at the tip is the only unknown of the ends
    integer, intent(in) :: alone               !! the mode that a line by itself is, with a mass at the tip; 0: not known
    type(choice_type), intent(inout) :: choices(:)
    type(problem_type) :: problem
    real(dp), allocatable :: least(:, :)
    integer :: best(size(choices)), k
    logical :: others(maxval([(size(choices(k)%candidates), k=1, size(choices))]))
    if (all([(size(choices(k)%candidates), k=1, size(choices))] == 0)) return
    problem = problem_of(square, rotates, tip, choices)
    call search(problem, least, best)
    do k = 1, size(choices)
      if (problem%count(k) == 0) cycle
      associate (choice => choices(k))
        choice%on_curve = best(k) > 0
        choice%best = best(k)
        if (best(k) == 0) choice%best = minloc(problem%cost(:problem%count(k), k), dim=1)
        if (problem%count(k) == 1) then
          choice%chosen = 1
          cycle
        end if
        others = .true.
        others(choice%best) = .false.
        choice%rival = minloc(least(:, k), dim=1, mask=others)
        if (best(k) > 0 .and. least(choice%rival, k) >= least(choice%best, k) + clear) choice%chosen = choice%best
        if (alone > 0 .and. size(choices) == 1) choice%chosen = findloc(problem%mode(:problem%count(k), k) == alone, .true., dim=1)
      end associate
    end do
  end subroutine choose_waves

  pure type(problem_type) function problem_of(square, rotates, tip, choices) result(problem)
    !! The candidates as points of the plane of β² and α⁴, with their deviations.
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
          problem%mode(j, k) = floor(candidates(j)%alpha/acos(-1.0_dp))
          if (.not. tip) cycle
          problem%mode(j, k) = mode_near(candidates(j)%alpha)
          problem%angle(j, k) = mass_angle(candidates(j)%alpha, problem%mode(j, k))
          step = min(deviation, candidates(j)%alpha/2)
          problem%angle_variance(j, k) = (problem%angle(j, k) - mass_angle(candidates(j)%alpha - step, problem%mode(j, k)))**2
        end do
      end associate
    end do
  end function problem_of

  subroutine search(problem, least, best)
    !! Begin a curve with each candidate of a few lines, or each pair where the beam rotates, and go on with the others.
    type(problem_type), intent(in) :: problem
    real(dp), allocatable, intent(out) :: least(:, :)  !! the cost of the best choice that takes a candidate, (candidate, line)
    integer, intent(out) :: best(:)            !! the best choice of all; 0: the line is not on the curve, (line)
    integer :: chosen(size(best)), anchors(min(most_anchors, size(best)))
    type(curve_type) :: curve
    real(dp) :: record
    integer :: a, b, i, j
    allocate (least(size(problem%power, 1), size(best)), source=huge(1.0_dp)/4)
    anchors = anchors_of(problem)
    record = huge(1.0_dp)/4
    best = 0
    do a = 1, size(anchors)
      do i = 1, problem%count(anchors(a))
        if (.not. problem%rotates) then
          chosen = 0
          chosen(anchors(a)) = i
          curve = begun(problem, anchors([a]), [i])
          call finish
          cycle
        end if
        do b = 1, size(anchors)
          if (problem%square(anchors(b)) <= problem%square(anchors(a))) cycle
          do j = 1, problem%count(anchors(b))
            chosen = 0
            chosen(anchors([a, b])) = [i, j]
            curve = begun(problem, anchors([a, b]), [i, j])
            call finish
          end do
        end do
      end do
    end do

  contains

    subroutine finish
      !! Go on with the curve, and note what it makes of each line.
      integer :: k
      if (.not. is_curve(curve)) return
      call go_on(problem, record + clear, chosen, curve)
      if (.not. curve%cost <= record + clear) return
      do k = 1, size(chosen)
        if (chosen(k) > 0) least(chosen(k), k) = min(least(chosen(k), k), curve%cost)
      end do
      if (curve%cost >= record) return
      record = curve%cost
      best = chosen
    end subroutine finish

  end subroutine search

  pure function anchors_of(problem) result(anchors)
    !! The lines with the fewest candidates, and of these the best known.
    type(problem_type), intent(in) :: problem
    integer :: anchors(min(most_anchors, size(problem%count)))
    real(dp) :: doubt(size(problem%count))
    integer :: i
    doubt = problem%count + minval(sqrt(problem%variance)/(problem%power + sqrt(problem%variance)), dim=1, &
      & mask=problem%power < huge(1.0_dp))
    where (problem%count == 0) doubt = huge(1.0_dp)
    do i = 1, size(anchors)
      anchors(i) = minloc(doubt, dim=1)
      doubt(anchors(i)) = huge(1.0_dp)
    end do
  end function anchors_of

  pure logical function is_curve(curve)
    !! Whether a curve is one of a beam: A > 0 and, within five deviations, B ≥ 0.
    type(curve_type), intent(in) :: curve
    is_curve = curve%value(1) > 0 .and. curve%value(2) >= -sqrt(worse*curve%covariance(2, 2)) &
      & .and. curve%cost < huge(1.0_dp)/8
  end function is_curve

  pure type(curve_type) function begun(problem, lines, own) result(curve)
    !! The curve through one candidate and the origin, or through two.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: lines(:), own(:)
    real(dp) :: slope(2, 2), far
    integer :: i
    if (size(lines) == 1) then
      curve%value(1) = problem%power(own(1), lines(1))/problem%square(lines(1))
      curve%covariance(1, 1) = problem%variance(own(1), lines(1))/problem%square(lines(1))**2
    else
      far = problem%square(lines(2)) - problem%square(lines(1))
      slope(1, :) = [-1.0_dp, 1.0_dp]/far
      slope(2, :) = [problem%square(lines(2)), -problem%square(lines(1))]/far
      do i = 1, 2
        curve%value = curve%value + slope(:, i)*problem%power(own(i), lines(i))
        curve%covariance = curve%covariance + problem%variance(own(i), lines(i))*spread(slope(:, i), 2, 2)*spread(slope(:, i), 1, 2)
      end do
    end if
    do i = 1, size(lines)
      curve%cost = curve%cost + problem%cost(own(i), lines(i))
      if (problem%tip) call add_mass(problem, own(i), lines(i), curve)
    end do
    if (size(lines) == 1) return
    if (problem%tip .and. problem%mode(own(1), lines(1)) == problem%mode(own(size(own)), lines(size(lines)))) &
      & curve%cost = huge(1.0_dp)/4
  end function begun

  pure subroutine add_mass(problem, own, line, curve)
    !! Take the mass that a candidate implies into the mean of all, and what it is away from it into the cost.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(inout) :: curve
    real(dp) :: share
    curve%cost = curve%cost + mass_cost(problem, own, line, curve)
    share = 1
    if (curve%angle_variance < huge(1.0_dp)) share = curve%angle_variance/(curve%angle_variance + problem%angle_variance(own, line))
    curve%angle = curve%angle + share*(problem%angle(own, line) - curve%angle)
    curve%angle_variance = share*problem%angle_variance(own, line)
  end subroutine add_mass

  pure real(dp) function mass_cost(problem, own, line, curve)
    !! What it costs that a candidate implies another mass; at most half of what a line costs that is on no curve.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(in) :: curve
    mass_cost = 0
    if (.not. problem%tip .or. .not. curve%angle_variance < huge(1.0_dp)) return
    mass_cost = min(worse/2, (problem%angle(own, line) - curve%angle)**2/ &
      & (curve%angle_variance + problem%angle_variance(own, line) + tiny(1.0_dp)))
  end function mass_cost

  pure subroutine go_on(problem, limit, chosen, curve)
    !! Take in the remaining lines, that first whose wave number the curve foresees best (recursive least squares). A line that
    !! has no candidate on the curve costs as much as one that is five deviations away.
    type(problem_type), intent(in) :: problem
    real(dp), intent(in) :: limit              !! of the cost, beyond which there is no point in going on
    integer, intent(inout) :: chosen(:)
    type(curve_type), intent(inout) :: curve
    logical :: waits(size(chosen))
    real(dp) :: cost, least
    integer :: i, j, next
    waits = chosen == 0 .and. problem%count > 0
    do i = 1, count(waits)
      if (curve%cost > limit) return
      next = foreseen_best(problem, waits, curve)
      waits(next) = .false.
      least = worse
      do j = 1, problem%count(next)
        if (problem%tip) then
          if (taken(problem%mode(j, next))) cycle
        end if
        cost = problem%cost(j, next) + apart(problem, j, next, curve) + mass_cost(problem, j, next, curve)
        if (cost >= least) cycle
        least = cost
        chosen(next) = j
      end do
      if (chosen(next) > 0) call take(problem, chosen(next), next, curve)
      if (chosen(next) == 0) curve%cost = curve%cost + worse
    end do
    curve%cost = curve%cost + gap_costs*gaps()

  contains

    pure logical function taken(mode)
      !! Whether some line is that mode already.
      integer, intent(in) :: mode
      integer :: k
      taken = .false.
      do k = 1, size(chosen)
        if (chosen(k) > 0) taken = taken .or. problem%mode(chosen(k), k) == mode
      end do
    end function taken

    pure integer function gaps()
      !! How many modes below the highest have no line.
      integer :: k, top
      top = 0
      do k = 1, size(chosen)
        if (chosen(k) > 0) top = max(top, problem%mode(chosen(k), k))
      end do
      gaps = max(0, top - count(problem%count > 0))
    end function gaps

  end subroutine go_on

  pure integer function foreseen_best(problem, waits, curve) result(best)
    !! The waiting line whose α the curve foresees with the least deviation.
    type(problem_type), intent(in) :: problem
    logical, intent(in) :: waits(:)
    type(curve_type), intent(in) :: curve
    real(dp) :: doubt, least, power
    integer :: k
    least = huge(1.0_dp)
    best = findloc(waits, .true., dim=1)
    do k = 1, size(waits)
      if (.not. waits(k)) cycle
      power = max(dot_product(curve%value, [problem%square(k), 1.0_dp]), epsilon(1.0_dp)*curve%value(1))
      doubt = foreseen_variance(problem, k, curve)/power**1.5_dp
      if (doubt >= least) cycle
      least = doubt
      best = k
    end do
  end function foreseen_best

  pure real(dp) function foreseen_variance(problem, line, curve) result(variance)
    !! The variance of the curve's α⁴ at a line.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: line
    type(curve_type), intent(in) :: curve
    variance = max(0.0_dp, dot_product([problem%square(line), 1.0_dp], matmul(curve%covariance, [problem%square(line), 1.0_dp])))
  end function foreseen_variance

  pure real(dp) function apart(problem, own, line, curve)
    !! The squared distance of a candidate from the curve in deviations.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(in) :: curve
    apart = (problem%power(own, line) - dot_product(curve%value, [problem%square(line), 1.0_dp]))**2/ &
      & (problem%variance(own, line) + foreseen_variance(problem, line, curve))
  end function apart

  pure subroutine take(problem, own, line, curve)
    !! Take a candidate into the curve.
    type(problem_type), intent(in) :: problem
    integer, intent(in) :: own, line
    type(curve_type), intent(inout) :: curve
    real(dp) :: gain(2), left(2, 2), variance
    variance = problem%variance(own, line) + foreseen_variance(problem, line, curve)
    gain = matmul(curve%covariance, [problem%square(line), 1.0_dp])/variance
    curve%cost = curve%cost + problem%cost(own, line) + apart(problem, own, line, curve)
    curve%value = curve%value + gain*(problem%power(own, line) - dot_product(curve%value, [problem%square(line), 1.0_dp]))
    left = -spread(gain, 2, 2)*spread([problem%square(line), 1.0_dp], 1, 2)
    left(1, 1) = left(1, 1) + 1
    left(2, 2) = left(2, 2) + 1
    curve%covariance = matmul(matmul(left, curve%covariance), transpose(left)) &
      & + problem%variance(own, line)*spread(gain, 2, 2)*spread(gain, 1, 2)  ! Joseph's form, which stays positive
    if (problem%tip) call add_mass(problem, own, line, curve)
  end subroutine take

end module bw_wave_choice
