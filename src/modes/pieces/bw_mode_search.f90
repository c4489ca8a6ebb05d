module bw_mode_search
  !! Modes of a beam of pieces by their numbers.
  !!
  !! Phases at the tip tell where to begin (bw_tip_phase). Inverse iteration runs to a mode; the count of modes on both sides
  !! tells which it is, and which others are so near that they show in its motion. A bracket of two counts closes in on the
  !! mode that is asked for, whatever inverse iteration was drawn to meanwhile: none is missed and none is found twice.
  use bw_double_double, only: dd, to_dd, operator(+), operator(-), operator(*)
  use bw_kinds, only: dp
  use bw_mode_cluster, only: find_resting, find_together, mode_cluster, polish
  use bw_mode_brackets, only: closed_to, counted, inside, middle, mode_bracket, open_for, width
  use bw_mode_probe, only: count_below, improve, mode_probe, piece_system, probe_at, probe_for, start_anew, &
    start_bodies, system_of
  use bw_piece_beam, only: cut_all, modes_at_rest, piece_beam
  use bw_modes_below_rest, only: growing_modes, may_grow
  use bw_piece_dispersion, only: mean_waves, next_half_wave
  use bw_piece_waves, only: frequency_at, parts_at_rest
  use bw_tip_phase, only: foresee
  implicit none (type, external)
  private
  public :: search_in, find_mode

  integer, parameter :: cuts = 2                   !! other ways to cut the pieces: in two, in three
  integer, parameter :: most_steps = 400
  integer, parameter :: most_parts = 1000          !! into which pieces are cut where the spin bends them: more would take minutes
  real(dp), parameter :: regular_enough = 1.0e-3_dp
    !! distance from clamped modes of the pieces, 0 … 1, from which a count is trusted
  real(dp), parameter :: near = 1.0e-2_dp          !! of the distance of two modes: from here inverse iteration is not watched
  real(dp), parameter :: rough_until = 1.0e-3_dp   !! likewise: the step after one so small may be the last
  real(dp), parameter :: rounding = 1.0e-8_dp      !! likewise: from here a step that does not get smaller is rounding
  real(dp), parameter :: converged = 2.0e-14_dp      !! likewise: a step that changes neither frequency nor motion
  real(dp), parameter :: three_digits = 3.0e-4_dp
    !! likewise: motions are off by about as much, and by some times more where another mode is near
  real(dp), parameter :: nearby = 0.6_dp         !! likewise: a motion from so far is about that of the mode (tuned)
  real(dp), parameter :: merged = 1.0e-3_dp        !! likewise: up to here inverse iteration mixes motions
  real(dp), parameter :: together = 1.0e-11_dp     !! tuned: likewise, up to here one frequency serves for the motions
  real(dp), parameter :: closest = 1.0e-9_dp       !! likewise: the width of brackets that are not halved any more

  type, public :: mode_search
    type(piece_system) :: system
    type(mode_probe) :: probe                      !! of the last mode that was found
    type(mode_probe) :: scout                      !! counts without moving the probe
    type(piece_system) :: finer(cuts)              !! the same beam in more pieces, where a piece is near its own modes
    type(mode_probe) :: finer_probe(cuts)
    type(mode_bracket) :: bracket
    integer :: growing = 0                         !! modes of λ < 0: out of plane sections may be turned away by the spin
    integer :: resting = 0                         !! modes of λ = 0
    type(mode_cluster) :: cluster                  !! the group that was found last
    logical :: possible = .true.                   !! false: the spin bends the beam in so many waves that no mode is looked for
    logical :: roughly = .false.                   !! three digits will do
    real(dp), allocatable :: any_drive(:, :, :)    !! one that no mode escapes
    integer :: last = -1                           !! number of the last mode that was found
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
    !! The same beam in more pieces, when it is first asked for.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: c
    integer :: i
    if (allocated(search%finer_probe(c)%ends)) return
    search%finer(c) = system_of(cut_all(search%system%beam, [(c + 1, i=1, size(search%system%piece))]))
    search%finer_probe(c) = probe_for(search%finer(c))
  end subroutine cut_finer

  subroutine find_mode(search, k, lambda, found)
    !! The frequency of mode k; its motion is the probe's.
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
        call find_resting(search%system, search%growing + 1, search%growing + search%resting, search%cluster)
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
    !! About how far apart modes near mode k are.
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    distance = 2.0_dp*abs(x%hi)/k
  end function mode_distance

  subroutine locate(search, k, lambda, alone, found)
    !! Mode k to the last digit, alone in the bracket, or about where it is with others in a bracket that has hardly any width.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(out) :: lambda
    logical, intent(out) :: alone, found
    type(dd) :: x
    real(dp) :: correction, mixture, step, before, room
    logical :: exact, final, gains
    integer :: i, n, strays
    call open_for(search%bracket, k, search%growing, search%growing + search%resting, search%system%beam%spin_squared)
    call begin(search, k, x)
    before = huge(before)
    strays = 0
    alone = .false.
    do i = 1, most_steps
      call probe_at(search%system, x, search%probe, rough=.not. (before < rough_until*mode_distance(k, x)))
      call improve(search%system, search%probe, correction, mixture)
      search%evaluations = search%evaluations + 1
      lambda = x + correction
      room = min(mode_distance(k, x), width(search%bracket))
      step = abs(correction)/room
      gains = abs(correction) < 0.5_dp*before
      exact = abs(correction) < converged*mode_distance(k, x)
      final = (exact .or. (step < rounding .and. .not. gains)) .and. .not. search%probe%frequency%rough
      if (search%roughly .and. i > 1) final = final .or. (gains .and. mixture < three_digits*mode_distance(k, x))
      if (.not. inside(search%bracket, lambda, 0.0_dp)) then
        strays = strays + 1
        if (mod(strays, 4) == 2) call start_anew(i, search%probe)      ! it was drawn elsewhere
        if (mod(strays, 4) == 0) call start_bodies(i, search%probe)
      else if (final) then
        call enclose(search, k, lambda, alone)
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

  pure subroutine begin(search, k, x)
    !! About where mode k is, and a drive that is about its own, as the phases at the tip tell nearby; where they do not, a drive
    !! that no mode escapes.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(out) :: x
    integer, parameter :: far = 4                  !! modes
    real(dp) :: step
    integer :: n
    x = first_guess(search, k)
    search%probe%drive = search%any_drive
    if (.not. x%hi > 0.0_dp) return
    call look(search, k, x, n)
    if (abs(k - n) > far) return
    call foresee(search%system, search%scout, k - n, step)
    if (.not. inside(search%bracket, x + step, 0.0_dp) .or. abs(step) > x%hi) return
    x = x + step
    if (abs(step) < nearby*mode_distance(k, x)) search%probe%drive = search%scout%drive
  end subroutine begin

  subroutine enclose(search, k, x, found)
    !! Count on both sides of a mode: is it mode k, and alone?
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
  end subroutine enclose

  logical function is_apart(search, k, x)
    !! No mode is so near to mode k that binary64 does not tell them apart.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    type(dd) :: edge
    edge = x + 0.99_dp*merged*mode_distance(k, x)  ! inside of where was counted
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
    !! Mode k with all modes that are near it, or near one of these.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: guess                  !! about its λ
    logical, intent(out) :: found
    type(mode_cluster) :: group
    type(dd), allocatable :: lambda(:)
    real(dp) :: apart
    logical :: alone
    integer :: j, last
    group%first = beyond_gap(search, k, guess, -merged*mode_distance(k, guess)) + 1
    group%last = beyond_gap(search, k, guess, merged*mode_distance(k, guess))
    apart = together*mode_distance(k, guess)
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
          call find_together(search%system, low%lambda + (-width(search%bracket)), apart, group%mode(j:last), lambda(j:last))
        end associate
      end if
      j = last + 1
    end do
    call polish(search%system, apart, group%mode, lambda)
    search%cluster = group
  end subroutine find_group

  integer function beyond_gap(search, k, guess, step) result(below)
    !! Modes below the first gap on one side of a frequency; −1 where none is.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: guess
    real(dp), intent(in) :: step                   !! its width, below 0 towards lower frequencies
    integer, parameter :: most = 40
    integer :: i, next
    call look(search, k, guess + step, below)
    do i = 2, most
      call look(search, k, guess + i*step, next)
      if (next == below) return
      below = next
    end do
    below = -1
  end function beyond_gap

  logical function counted_at(search, k, x, below)
    !! So many modes lie below a frequency.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k, below
    type(dd), intent(in) :: x
    integer :: n
    call look(search, k, x, n)
    counted_at = n == below
  end function counted_at

  pure subroutine look(search, k, x, n)
    !! Count the modes below a frequency by a probe of its own; the bracket closes.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    integer, intent(out) :: n
    search%scout%drive = 0.0_dp
    call probe_at(search%system, x, search%scout, rough=.true.)
    search%evaluations = search%evaluations + 1
    call count_at(search, k, search%scout, n)
  end subroutine look

  pure subroutine count_at(search, k, probe, n)
    !! Modes below the frequency of a probe, by which the bracket closes.
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

  pure type(dd) function first_guess(search, k) result(x)
    !! As many half waves further than the last mode, or the lower end of the bracket, as modes are between.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k
    real(dp), parameter :: beyond = 1.05_dp        ! half waves: on the way the upper end of the bracket closes
    x = middle(search%bracket)
    associate (low => search%bracket%low, system => search%system)
      if (search%last == k - 1 .and. search%last_lambda%hi > 0.0_dp) then
        x = to_dd(next_half_wave(system%beam, system%piece, search%last_lambda%hi, beyond))
      else if (low%lambda%hi >= 0.0_dp) then
        x = to_dd(next_half_wave(system%beam, system%piece, low%lambda%hi, real(k - low%below, dp)))
      end if
    end associate
    if (.not. inside(search%bracket, x, 0.0_dp)) x = middle(search%bracket)
  end function first_guess

  pure type(dd) function next_guess(search, k, n, x, correction, gains) result(guess)
    !! Where inverse iteration points, if that is inside of the bracket and gains; else by the number of half waves or by
    !! halves.
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
