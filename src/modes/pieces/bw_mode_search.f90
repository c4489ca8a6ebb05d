module bw_mode_search
  !! Modes of a beam of pieces by their numbers.
  !!
  !! The number of half waves gives a first guess. Inverse iteration converges to some mode; counts on both sides identify
  !! it, and show others that are so near that they affect its motion. A bracket of two counts narrows to the wanted mode
  !! even if inverse iteration strays to others: none is missed and none is found twice.
  use bw_double_double, only: dd, to_dd, operator(+), operator(-), operator(*)
  use bw_kinds, only: dp
  use bw_mode_cluster, only: find_rigid_modes, find_clustered_modes, mode_cluster, refine_cluster
  use bw_mode_brackets, only: closed_to, counted, inside, middle, mode_bracket, open_for, width
  use bw_mode_probe, only: count_below, iterate_inverse, mode_probe, piece_system, probe_at, probe_for, set_random_drive, &
    start_bodies, system_of
  use bw_piece_beam, only: cut_all, modes_at_rest, piece_beam
  use bw_modes_below_rest, only: growing_modes, may_grow
  use bw_piece_dispersion, only: next_half_wave
  use bw_piece_waves, only: parts_at_rest
  implicit none (type, external)
  private
  public :: search_in, find_mode

  integer, parameter :: cuts = 2                   !! alternative cuts of the pieces: in two, in three
  integer, parameter :: most_steps = 400
  integer, parameter :: most_parts = 1000          !! limit of pieces where rotation requires cuts; more would take minutes
  real(dp), parameter :: regular_enough = 1.0e-3_dp
    !! least distance from clamped modes of the pieces, 0 … 1, for a reliable count
  real(dp), parameter :: near = 1.0e-2_dp  !! of the mode spacing: below it steps of inverse iteration are taken without counts
  real(dp), parameter :: rough_until = 1.0e-3_dp   !! likewise: after such a step the next may be the last
  real(dp), parameter :: rounding = 1.0e-8_dp      !! likewise: below it steps that do not shrink are rounding
  real(dp), parameter :: converged = 2.0e-14_dp      !! likewise: such a step changes neither frequency nor motion
  real(dp), parameter :: merged = 1.0e-3_dp        !! likewise: up to here inverse iteration mixes motions
  real(dp), parameter :: together = 1.0e-11_dp     !! tuned, likewise: up to here one frequency serves for several motions
  real(dp), parameter :: closest = 1.0e-9_dp       !! likewise: width at which brackets are not halved further

  type, public :: mode_search
    type(piece_system) :: system
    type(mode_probe) :: probe                      !! of the last mode found
    type(mode_probe) :: scout                      !! for counts only
    type(piece_system) :: finer(cuts)              !! the same beam in more pieces, if a piece is near its own modes
    type(mode_probe) :: finer_probe(cuts)
    type(mode_bracket) :: bracket
    integer :: growing = 0                         !! modes with λ < 0: out of plane rotation may destabilise sections
    integer :: resting = 0                         !! modes with λ = 0
    type(mode_cluster) :: cluster                  !! the last group found
    logical :: possible = .true.                   !! false: rotation bends the beam in too many waves for a search
    real(dp), allocatable :: any_drive(:, :, :)    !! one that excites all modes
    integer :: last = -1                           !! number of the last mode found
    type(dd) :: last_lambda                        !! its frequency
    integer :: evaluations = 0
  end type mode_search

contains

  pure type(mode_search) function search_in(beam) result(search)
    type(piece_beam), intent(in) :: beam
    search%system = system_of(beam)
    search%resting = modes_at_rest(beam)
    if (may_grow(beam) .or. search%resting > 0) search%possible = sum(parts_at_rest(beam)) <= size(beam%piece) + most_parts
    if (may_grow(beam) .and. search%possible) search%growing = growing_modes(beam, search%resting > 0)
    if (search%growing + search%resting > 0 .and. search%possible) search%system = system_of(cut_all(beam, parts_at_rest(beam)))
    search%probe = probe_for(search%system)
    search%scout = search%probe
    search%any_drive = search%probe%drive
  end function search_in

  pure subroutine cut_finer(search, c)
    !! Cut the beam into more pieces, once needed.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: c
    integer :: i
    if (allocated(search%finer_probe(c)%ends)) return
    search%finer(c) = system_of(cut_all(search%system%beam, [(c + 1, i=1, size(search%system%piece))]))
    search%finer_probe(c) = probe_for(search%finer(c))
  end subroutine cut_finer

  subroutine find_mode(search, k, lambda, found)
    !! Find λ of mode k. The probe has its motion.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k                       !! ≥ 1
    type(dd), intent(out) :: lambda
    logical, intent(out) :: found
    logical :: alone
    found = search%possible
    if (.not. found) return
    alone = .false.
    if (k < search%cluster%first .or. k > search%cluster%last) then
      if (k > search%growing .and. k <= search%growing + search%resting) then
        call find_rigid_modes(search%system, search%growing + 1, search%growing + search%resting, search%cluster)
      else
        call locate(search, k, lambda, alone, found)
        alone = alone .and. found
        if (alone) alone = is_apart(search, k, lambda)
        if (.not. alone) call find_group(search, k, lambda, found)
      end if
    end if
    if (.not. found) return
    if (.not. alone) search%probe = search%cluster%mode(k)
    if (.not. alone) lambda = search%probe%frequency%lambda
    search%last = k
    search%last_lambda = lambda
  end subroutine find_mode

  elemental real(dp) function mode_distance(k, x) result(distance)
    !! Estimate the spacing of modes near mode k.
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    distance = 2.0_dp*abs(x%hi)/k
  end function mode_distance

  subroutine locate(search, k, lambda, alone, found)
    !! Locate mode k to the last digit, alone in the bracket, or approximately with others in a very narrow bracket.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(out) :: lambda
    logical, intent(out) :: alone, found
    type(dd) :: x
    real(dp) :: correction, step, before, room
    logical :: exact, final, gains
    integer :: i, n, strays
    call open_for(search%bracket, k, search%growing, search%growing + search%resting, search%system%beam%spin_squared)
    x = initial_guess(search, k)
    search%probe%drive = search%any_drive
    before = huge(before)
    strays = 0
    alone = .false.
    do i = 1, most_steps
      call probe_at(search%system, x, search%probe, rough=.not. (before < rough_until*mode_distance(k, x)))
      call iterate_inverse(search%system, search%probe, correction)
      search%evaluations = search%evaluations + 1
      lambda = x + correction
      room = min(mode_distance(k, x), width(search%bracket))
      step = abs(correction)/room
      gains = abs(correction) < 0.5_dp*before
      exact = abs(correction) < converged*mode_distance(k, x)
      final = (exact .or. (step < rounding .and. .not. gains)) .and. .not. search%probe%frequency%rough
      if (.not. inside(search%bracket, lambda, 0.0_dp)) then
        strays = strays + 1
        if (mod(strays, 4) == 2) call set_random_drive(i, search%probe)      ! it strayed to another mode
        if (mod(strays, 4) == 0) call start_bodies(i, search%probe)
      else if (final) then
        call verify_mode(search, k, lambda, alone)
        found = alone .or. width(search%bracket) < 3.0_dp*rounding*mode_distance(k, x)
        if (found) return
        call start_bodies(i, search%probe)
        x = middle(search%bracket)
        before = huge(before)
        cycle
      end if
      if (step < near .and. gains .and. inside(search%bracket, lambda, 0.0_dp)) then
        x = lambda
      else
        call count_at(search, k, search%probe, n)
        x = next_guess(search, k, n, x, correction, gains)
      end if
      before = abs(correction)
      lambda = middle(search%bracket)
      room = closest*mode_distance(k, lambda)
      if (closed_to(search%bracket, k - 1, lambda) .and. closed_to(search%bracket, k, lambda)) room = 1.0e-3_dp*room
      found = width(search%bracket) < room
      if (found) return
    end do
  end subroutine locate

  subroutine verify_mode(search, k, x, found)
    !! Count on both sides of a mode, to check that it is mode k, alone.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    logical, intent(out) :: found
    real(dp) :: margin
    margin = min(rounding*mode_distance(k, x), 0.5_dp*width(search%bracket))
    found = closed_to(search%bracket, k, x + margin)
    if (.not. found) found = counted_at(search, k, x + merged*mode_distance(k, x), k)
    if (.not. found) found = counted_at(search, k, x + margin, k)
    if (.not. found .or. closed_to(search%bracket, k - 1, x + (-margin))) return
    found = counted_at(search, k, x + (-merged*mode_distance(k, x)), k - 1)
    if (.not. found) found = counted_at(search, k, x + (-margin), k - 1)
  end subroutine verify_mode

  logical function is_apart(search, k, x)
    !! Return whether all other modes are far enough from mode k for binary64.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    type(dd) :: edge
    edge = x + 0.99_dp*merged*mode_distance(k, x)  ! inside the counts made
    is_apart = closed_to(search%bracket, k, edge)
    if (.not. is_apart) is_apart = counted_at(search, k, edge, k)
    if (.not. is_apart) return
    edge = x + (-0.99_dp*merged*mode_distance(k, x))
    is_apart = closed_to(search%bracket, k - 1, edge)
    if (.not. is_apart .and. search%last == k - 1) then
      edge = edge - search%last_lambda
      is_apart = edge%hi > 0.0_dp
    else if (.not. is_apart) then
      is_apart = counted_at(search, k, edge, k - 1)
    end if
  end function is_apart

  subroutine find_group(search, k, guess, found)
    !! Find mode k with all modes near it, or near one of these.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: guess                  !! an estimate of its λ
    logical, intent(out) :: found
    type(mode_cluster) :: group
    type(dd), allocatable :: lambda(:)
    real(dp) :: separation
    logical :: alone
    integer :: j, last
    group%first = beyond_gap(search, k, guess, -merged*mode_distance(k, guess)) + 1
    group%last = beyond_gap(search, k, guess, merged*mode_distance(k, guess))
    separation = together*mode_distance(k, guess)
    found = group%first > 0 .and. group%first <= k .and. k <= group%last
    if (.not. found) return
    allocate (group%mode(group%first:group%last), lambda(group%first:group%last))
    j = group%first
    do while (j <= group%last)
      call locate(search, j, lambda(j), alone, found)
      if (.not. found) return
      last = j
      if (alone) then
        group%mode(j) = search%probe
      else
        associate (low => search%bracket%low, high => search%bracket%high(search%bracket%highs))
          last = high%below
          found = low%below == j - 1 .and. last <= group%last
          if (.not. found) return
          call find_clustered_modes(search%system, low%lambda + (-width(search%bracket)), separation, group%mode(j:last), &
            & lambda(j:last))
        end associate
      end if
      j = last + 1
    end do
    call refine_cluster(search%system, separation, group%mode, lambda)
    search%cluster = group
  end subroutine find_group

  integer function beyond_gap(search, k, guess, step) result(below)
    !! Count the modes below the first gap on one side of a frequency; −1 if there is no gap.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: guess
    real(dp), intent(in) :: step                   !! width of the gap, negative towards lower frequencies
    integer, parameter :: most = 40
    integer :: i, next
    call count_with_scout(search, k, guess + step, below)
    do i = 2, most
      call count_with_scout(search, k, guess + i*step, next)
      if (next == below) return
      below = next
    end do
    below = -1
  end function beyond_gap

  logical function counted_at(search, k, x, below)
    !! Return whether `below` modes lie below a frequency.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k, below
    type(dd), intent(in) :: x
    integer :: n
    call count_with_scout(search, k, x, n)
    counted_at = n == below
  end function counted_at

  pure subroutine count_with_scout(search, k, x, n)
    !! Count the modes below a frequency with the scout, and narrow the bracket.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    integer, intent(out) :: n
    search%scout%drive = 0.0_dp
    call probe_at(search%system, x, search%scout, rough=.true.)
    search%evaluations = search%evaluations + 1
    call count_at(search, k, search%scout, n)
  end subroutine count_with_scout

  pure subroutine count_at(search, k, probe, n)
    !! Count the modes below the frequency of a probe, and narrow the bracket.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(mode_probe), intent(in) :: probe
    integer, intent(out) :: n
    real(dp) :: regular, best
    integer :: c, other
    call count_below(search%system, probe, n, best)
    do c = 1, cuts
      if (best >= regular_enough) exit
      call cut_finer(search, c)
      call probe_at(search%finer(c), probe%frequency%lambda, search%finer_probe(c), rough=.true.)
      call count_below(search%finer(c), search%finer_probe(c), other, regular)
      if (regular <= best) cycle
      best = regular
      n = other
    end do
    call counted(search%bracket, k, probe%frequency%lambda, n)
  end subroutine count_at

  pure type(dd) function initial_guess(search, k) result(x)
    !! Advance from the last mode, or the lower end of the bracket, by as many half waves as modes.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k
    real(dp), parameter :: beyond = 1.05_dp        ! half waves: overshoots, so that the upper end of the bracket closes
    x = middle(search%bracket)
    associate (low => search%bracket%low, system => search%system)
      if (search%last == k - 1 .and. search%last_lambda%hi > 0.0_dp) then
        x = to_dd(next_half_wave(system%beam, system%piece, search%last_lambda%hi, beyond))
      else if (low%lambda%hi >= 0.0_dp) then
        x = to_dd(next_half_wave(system%beam, system%piece, low%lambda%hi, real(k - low%below, dp)))
      end if
    end associate
    if (.not. inside(search%bracket, x, 0.0_dp)) x = middle(search%bracket)
  end function initial_guess

  pure type(dd) function next_guess(search, k, n, x, correction, gains) result(guess)
    !! Take the step of inverse iteration if it stays in the bracket and converges; else go by half waves or bisection.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k, n                    !! modes below x
    type(dd), intent(in) :: x
    real(dp), intent(in) :: correction
    logical, intent(in) :: gains
    guess = x + correction
    if (gains .and. inside(search%bracket, guess, 0.0_dp) .and. (n == k .or. n == k - 1 .or. x%hi <= 0.0_dp)) return
    guess = middle(search%bracket)
    if (x%hi <= 0.0_dp .or. (search%bracket%highs > 0 .and. abs(n - k) < 4)) return
    guess = to_dd(next_half_wave(search%system%beam, search%system%piece, x%hi, k - n - 0.5_dp))
    if (.not. inside(search%bracket, guess, 0.0_dp)) guess = middle(search%bracket)
  end function next_guess

end module bw_mode_search
