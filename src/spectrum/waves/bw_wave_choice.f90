module bw_wave_choice
  !! Which of the wave numbers that fit a line alike is the line's: those of all lines lie on one curve of a uniform beam, and with a
  !! mass at the tip all imply the same mass. What is chosen fits much better than every choice that contradicts it; otherwise
  !! nothing is.
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  use bw_shape_fit, only: worse
  use bw_wave_candidates, only: choice_type, problem_of, problem_type
  use bw_wave_curve, only: apart, begun, curve_type, foreseen_variance, is_curve, mass_cost, take
  implicit none (type, external)
  private
  public :: choose_waves

  integer, parameter :: most_anchors = 6       !! lines that a curve is begun with
  real(dp), parameter :: clear = 2*log(1.0e4_dp)  !! that much better than any contradiction
  real(dp), parameter :: gap_costs = 2*log(10.0_dp)  !! of a mode without a line, below the highest that has one

contains

  subroutine choose_waves(square, rotates, tip, alone, choices, monitor)
    !! Choose a candidate for each line, or name the two best where nothing tells.
    real(dp), intent(in) :: square(:)          !! β² of the undamped line, (line)
    logical, intent(in) :: rotates             !! in the plane of bending
    logical, intent(in) :: tip                 !! a mass at the tip is the only unknown of the ends
    integer, intent(in) :: alone               !! the mode that a line by itself is, with a mass at the tip; 0: not known
    type(choice_type), intent(inout) :: choices(:)
    class(monitor_type), intent(inout), optional :: monitor    !! nothing is chosen where it asks to stop
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
    !! Begin a curve with each candidate of a few lines, or each pair where the beam rotates, and go on with the others.
    type(problem_type), intent(in) :: problem
    real(dp), allocatable, intent(out) :: least(:, :)  !! the cost of the best choice that takes a candidate, (candidate, line)
    integer, intent(out) :: best(:)            !! the best choice of all; 0: the line is not on the curve, (line)
    class(monitor_type), intent(inout), optional :: monitor
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
        if (stops(monitor)) return
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

end module bw_wave_choice
