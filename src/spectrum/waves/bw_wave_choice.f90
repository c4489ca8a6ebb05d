module bw_wave_choice
  !! The choice among wave numbers that fit a line equally well: those of all lines lie on one curve of a uniform beam, and with a
  !! mass at the tip all imply the same mass. A wave number is chosen only if it fits much better than every choice that
  !! contradicts it.
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  use bw_shape_fit, only: worse
  use bw_wave_candidates, only: choice_type, problem_of, problem_type
  use bw_wave_curve, only: curve_through, curve_type, distance_cost, is_curve, mass_cost, predicted_variance, take
  implicit none (type, external)
  private
  public :: choose_waves

  integer, parameter :: most_anchors = 6       !! lines from which curves start
  real(dp), parameter :: clear = 2*log(1.0e4_dp)  !! cost by which a choice must be better than any that contradicts it
  real(dp), parameter :: gap_costs = 2*log(10.0_dp)  !! cost of a mode without a line, below the highest that has one

contains

  subroutine choose_waves(square, rotates, tip, alone, choices, monitor)
    !! Choose a candidate for each line, or name the two best if none is clearly better.
    real(dp), intent(in) :: square(:)          !! β² of the undamped line, (line)
    logical, intent(in) :: rotates             !! in the plane of bending
    logical, intent(in) :: tip                 !! a mass at the tip is the only unknown of the ends
    integer, intent(in) :: alone               !! mode number of a single line, with a mass at the tip; 0: not known
    type(choice_type), intent(inout) :: choices(:)
    class(monitor_type), intent(inout), optional :: monitor    !! nothing is chosen after a stop request
    type(problem_type) :: problem
    real(dp), allocatable :: least(:, :)
    integer :: best(size(choices)), k
    logical :: others(maxval([(size(choices(k)%candidates), k=1, size(choices))]))
    if (all([(size(choices(k)%candidates), k=1, size(choices))] == 0)) return
    problem = problem_of(square, rotates, tip, choices)
    call search(problem, least, best, monitor)
    if (stops(monitor)) return
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

  subroutine search(problem, least, best, monitor)
    !! Start a curve from each candidate of a few lines, or from each pair if the beam rotates, and extend it to the other lines.
    type(problem_type), intent(in) :: problem
    real(dp), allocatable, intent(out) :: least(:, :)  !! lowest cost of a choice that contains the candidate, (candidate, line)
    integer, intent(out) :: best(:)            !! candidates of the best choice; 0: the line is not on the curve, (line)
    class(monitor_type), intent(inout), optional :: monitor
    integer :: chosen(size(best)), anchors(min(most_anchors, size(best)))
    type(curve_type) :: curve
    real(dp) :: lowest
    integer :: a, b, i, j
    allocate (least(size(problem%power, 1), size(best)), source=huge(1.0_dp)/4)
    anchors = anchors_of(problem)
    lowest = huge(1.0_dp)/4
    best = 0
    do a = 1, size(anchors)
      do i = 1, problem%count(anchors(a))
        if (.not. problem%rotates) then
          chosen = 0
          chosen(anchors(a)) = i
          curve = curve_through(problem, anchors([a]), [i])
          call complete
          cycle
        end if
        if (stops(monitor)) return
        do b = 1, size(anchors)
          if (problem%square(anchors(b)) <= problem%square(anchors(a))) cycle
          do j = 1, problem%count(anchors(b))
            chosen = 0
            chosen(anchors([a, b])) = [i, j]
            curve = curve_through(problem, anchors([a, b]), [i, j])
            call complete
          end do
        end do
      end do
    end do

  contains

    subroutine complete
      !! Extend the curve, and record its cost for the candidates on it.
      integer :: k
      if (.not. is_curve(curve)) return
      call extend(problem, lowest + clear, chosen, curve)
      if (.not. curve%cost <= lowest + clear) return
      do k = 1, size(chosen)
        if (chosen(k) > 0) least(chosen(k), k) = min(least(chosen(k), k), curve%cost)
      end do
      if (curve%cost >= lowest) return
      lowest = curve%cost
      best = chosen
    end subroutine complete

  end subroutine search

  pure function anchors_of(problem) result(anchors)
    !! The lines with the fewest candidates, and among these the best known ones.
    type(problem_type), intent(in) :: problem
    integer :: anchors(min(most_anchors, size(problem%count)))
    real(dp) :: uncertainty(size(problem%count))
    integer :: i
    uncertainty = problem%count + minval(sqrt(problem%variance)/(problem%power + sqrt(problem%variance)), dim=1, &
      & mask=problem%power < huge(1.0_dp))
    where (problem%count == 0) uncertainty = huge(1.0_dp)
    do i = 1, size(anchors)
      anchors(i) = minloc(uncertainty, dim=1)
      uncertainty(anchors(i)) = huge(1.0_dp)
    end do
  end function anchors_of

  pure subroutine extend(problem, limit, chosen, curve)
    !! Add the remaining lines, in each step the one that the curve predicts most precisely (recursive least squares). A line
    !! without a candidate on the curve costs as much as one that is five standard deviations away.
    type(problem_type), intent(in) :: problem
    real(dp), intent(in) :: limit              !! of the cost, above which the curve is abandoned
    integer, intent(inout) :: chosen(:)
    type(curve_type), intent(inout) :: curve
    logical :: remaining(size(chosen))
    real(dp) :: cost, least
    integer :: i, j, next
    remaining = chosen == 0 .and. problem%count > 0
    do i = 1, count(remaining)
      if (curve%cost > limit) return
      next = best_predicted(problem, remaining, curve)
      remaining(next) = .false.
      least = worse
      do j = 1, problem%count(next)
        if (problem%tip) then
          if (taken(problem%mode(j, next))) cycle
        end if
        cost = problem%cost(j, next) + distance_cost(problem, j, next, curve) + mass_cost(problem, j, next, curve)
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
      !! Whether a line is assigned to that mode already.
      integer, intent(in) :: mode
      integer :: k
      taken = .false.
      do k = 1, size(chosen)
        if (chosen(k) > 0) taken = taken .or. problem%mode(chosen(k), k) == mode
      end do
    end function taken

    pure integer function gaps()
      !! Number of modes below the highest that have no line.
      integer :: k, top
      top = 0
      do k = 1, size(chosen)
        if (chosen(k) > 0) top = max(top, problem%mode(chosen(k), k))
      end do
      gaps = max(0, top - count(problem%count > 0))
    end function gaps

  end subroutine extend

  pure integer function best_predicted(problem, remaining, curve) result(best)
    !! The remaining line whose α the curve predicts with the smallest standard deviation.
    type(problem_type), intent(in) :: problem
    logical, intent(in) :: remaining(:)
    type(curve_type), intent(in) :: curve
    real(dp) :: uncertainty, least, power
    integer :: k
    least = huge(1.0_dp)
    best = findloc(remaining, .true., dim=1)
    do k = 1, size(remaining)
      if (.not. remaining(k)) cycle
      power = max(dot_product(curve%value, [problem%square(k), 1.0_dp]), epsilon(1.0_dp)*curve%value(1))
      uncertainty = predicted_variance(problem, k, curve)/power**1.5_dp
      if (uncertainty >= least) cycle
      least = uncertainty
      best = k
    end do
  end function best_predicted

end module bw_wave_choice
