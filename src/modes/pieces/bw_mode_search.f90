module bw_mode_search
  !! Modes of a beam of pieces by their numbers.
  !!
  !! Inverse iteration runs to a mode; the count of modes below tells which. A bracket of two frequencies closes in on the
  !! mode that is asked for until it holds no other, whatever inverse iteration was drawn to meanwhile: none is missed and
  !! none is found twice.
  use bw_double_double, only: dd, to_dd, operator(+), operator(-), operator(*)
  use bw_kinds, only: dp
  use bw_mode_cluster, only: mode_cluster, separate, take
  use bw_mode_probe, only: count_below, improve, mode_probe, piece_system, probe_at, probe_for, start_anew, system_of
  use bw_piece_beam, only: cut_all, modes_at_rest, piece_beam
  use bw_piece_dispersion, only: half_waves
  use bw_piece_waves, only: frequency_at, parts_at_rest
  implicit none (type, external)
  private
  public :: search_in, find_mode, inside, is_double, is_resting, stands_alone, take_apart

  integer, parameter :: cuts = 2                   !! other ways to cut the pieces: in two, in three
  integer, parameter :: most_steps = 400
  integer, parameter :: depth = 16                 !! upper ends of brackets that are remembered
  real(dp), parameter :: regular_enough = 1.0e-3_dp
    !! distance from clamped modes of the pieces, 0 … 1, from which a count is trusted
  real(dp), parameter :: near = 1.0e-6_dp          !! of the distance of two modes: from here the count is asked which it is
  real(dp), parameter :: settled = 1.0e-14_dp      !! likewise: from here a step is rounding
  integer, parameter :: most_polish = 20
  real(dp), parameter :: isolated = 0.25_dp        !! likewise: modes that are closer show in each other's motions by rounding
  real(dp), parameter :: sure = 1.0e-12_dp         !! likewise: from here counts are not rounded
  real(dp), parameter :: closest = 4.0e-12_dp      !! likewise: modes that are closer are taken apart together

  real(dp), parameter :: same = 1.0e-26_dp         !! part of λ: modes that nothing here tells apart

  type :: separator
    type(dd) :: lambda
    integer :: below = 0                           !! modes below it
  end type separator

  type, public :: mode_search
    type(piece_system) :: system
    type(mode_probe) :: probe
    type(mode_probe) :: scout                      !! counts without moving the probe
    type(piece_system) :: finer(cuts)              !! the same beam in more pieces, where a piece is near its own modes
    type(mode_probe) :: finer_probe(cuts)
    type(separator) :: low                         !! of the last number asked for
    type(separator) :: high(depth)                 !! descending
    integer :: highs = 0
    integer :: growing = 0                         !! modes of λ < 0: out of plane sections may be turned away by the spin
    integer :: resting = 0                         !! modes of λ = 0
    type(mode_cluster) :: cluster                  !! the last modes that were taken apart together
    logical :: rough = .false.                     !! rounding took digits from the last mode that was found
    integer :: evaluations = 0
  end type mode_search

contains

  pure type(mode_search) function search_in(beam) result(search)
    type(piece_beam), intent(in) :: beam
    type(piece_beam) :: fine
    real(dp) :: regular
    integer :: c, i
    search%system = system_of(beam)
    search%resting = modes_at_rest(beam)
    if (search%resting > 0 .or. may_grow(beam)) then
      fine = cut_all(beam, parts_at_rest(beam))          ! pieces that are short where λ ≤ 0
      search%finer(1) = system_of(fine)
      search%probe = probe_for(search%finer(1))
      call probe_at(search%finer(1), beam%spin_squared*(-1.0e-12_dp), search%probe)
      call count_below(search%finer(1), search%probe, search%growing, regular)
      if (.not. may_grow(beam)) search%growing = 0
      if (search%growing + search%resting > 0) search%system = search%finer(1)
    end if
    search%probe = probe_for(search%system)
    search%scout = search%probe
    do c = 1, cuts
      search%finer(c) = system_of(cut_all(search%system%beam, [(c + 1, i=1, size(search%system%piece))]))
      search%finer_probe(c) = probe_for(search%finer(c))
    end do
    search%low%below = huge(1)
  end function search_in

  pure logical function may_grow(beam)
    !! Out of plane, by rotary inertia.
    type(piece_beam), intent(in) :: beam
    may_grow = .not. beam%in_plane .and. beam%spin_squared%hi > 0.0_dp .and. any(beam%piece%rotary%hi > 0.0_dp)
  end function may_grow

  subroutine find_mode(search, k, lambda, found)
    !! The frequency of mode k; its motion is the probe's.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k                       !! ≥ 1
    type(dd), intent(out) :: lambda
    logical, intent(out) :: found
    type(dd) :: x, target
    real(dp) :: correction, slope, step, last
    integer :: i, n
    if (is_resting(search, k)) call take_resting(search)
    if (is_together(search, k)) then
      call take_together(search, k, lambda)
      found = .true.
      return
    end if
    call open_bracket(search, k)
    call start_anew(1, search%probe)
    x = first_guess(search, k)
    last = huge(last)
    found = .false.
    do i = 1, most_steps
      call probe_at(search%system, x, search%probe)
      call improve(search%system, search%probe, correction)
      search%evaluations = search%evaluations + 1
      slope = mode_density(k, x)
      step = abs(correction)*slope
      target = x + correction
      if (step < near .and. inside(search, target)) then
        if (.not. alone(search, k)) call certify(search, k, target, 4.0_dp*abs(correction), slope)
        if (alone(search, k) .and. inside(search, target) .and. .not. is_cluster(search, slope)) then
          call polish(search, k, x, correction, lambda, found)
          if (found) call confirm(search, k, lambda, found)
          if (found) return
        end if
        call look(search, k, middle(search))
        target = middle(search)
      else
        call count_at(search, k, search%probe, n)
        target = next_guess(search, k, n, x, correction, step < 0.5_dp*last)
      end if
      last = step
      x = target
      found = is_cluster(search, slope)
      if (found) then
        lambda = middle(search)
        call take_apart(search, k, lambda)
        return
      end if
    end do
  end subroutine find_mode

  elemental real(dp) function mode_density(k, x) result(slope)
    !! About how many modes there are to a unit of λ near mode k; at least to |λ| itself.
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    slope = 0.5_dp*k/max(abs(x%hi), tiny(slope))
  end function mode_density

  pure subroutine polish(search, k, start, first, lambda, found)
    !! Inverse iteration to the last digit in a bracket that holds mode k alone.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: start                  !! where the probe is
    real(dp), intent(in) :: first                  !! the correction there
    type(dd), intent(out) :: lambda
    logical, intent(out) :: found
    real(dp) :: correction, slope, last
    integer :: i, stalled
    slope = mode_density(k, start)
    correction = first
    lambda = start + correction
    stalled = 0
    do i = 1, most_polish
      if (abs(correction)*slope < settled .or. stalled == 2) exit
      last = abs(correction)
      call probe_at(search%system, lambda, search%probe)
      call improve(search%system, search%probe, correction)
      search%evaluations = search%evaluations + 1
      lambda = lambda + correction
      if (abs(correction) > 0.5_dp*last .and. is_small(search, lambda, correction)) stalled = stalled + 1      ! by rounding
    end do
    search%rough = abs(correction)*slope > settled
    found = inside(search, lambda) .and. (abs(correction)*slope < settled .or. is_small(search, lambda, correction))
  end subroutine polish

  pure subroutine confirm(search, k, lambda, found)
    !! Where an end of the bracket is next to the mode, its count may have been rounded: count again a little further off.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: lambda
    logical, intent(out) :: found
    real(dp) :: margin
    type(dd) :: gap
    margin = sure/mode_density(k, lambda)
    gap = lambda - search%low%lambda
    if (gap%hi < margin) call look(search, k, lambda + (-margin))
    gap = search%high(search%highs)%lambda - lambda
    if (gap%hi < margin) call look(search, k, lambda + margin)
    found = alone(search, k) .and. inside(search, lambda)
  end subroutine confirm

  pure logical function is_small(search, lambda, correction)
    !! Beside the distance to any other mode, which is outside of the bracket.
    type(mode_search), intent(in) :: search
    type(dd), intent(in) :: lambda
    real(dp), intent(in) :: correction
    real(dp), parameter :: small = 1.0e-4_dp
    type(dd) :: below, above
    below = lambda - search%low%lambda
    above = search%high(search%highs)%lambda - lambda
    is_small = abs(correction) < small*min(below%hi, above%hi)
  end function is_small

  pure logical function is_cluster(search, slope)
    !! The bracket holds modes and has no width.
    type(mode_search), intent(in) :: search
    real(dp), intent(in) :: slope                  !! modes to a unit of λ
    type(dd) :: width
    is_cluster = .false.
    if (search%highs == 0) return
    width = search%high(search%highs)%lambda - search%low%lambda
    is_cluster = width%hi*slope < closest
  end function is_cluster

  subroutine take_apart(search, k, lambda)
    !! Mode k and all that are next to it.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(inout) :: lambda              !! about where they are; of mode k
    call gather(search, k, lambda, closest/mode_density(k, lambda))
    call separate(search%system, lambda, search%low%below + 1, search%high(search%highs)%below, search%probe, search%cluster)
    call take_together(search, k, lambda)
  end subroutine take_apart

  subroutine gather(search, k, center, least)
    !! Widen the bracket until no mode outside of it is near beside its width.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: center
    real(dp), intent(in) :: least                  !! half of the width to begin with
    integer, parameter :: most = 4
    real(dp), parameter :: far = 100.0_dp
    real(dp) :: width
    logical :: apart, apart_too
    integer :: i
    width = least
    do i = 1, most
      call look(search, k, center + (-width))
      call look(search, k, center + width)
      call count_apart(search, center + (-far*width), search%low%below, apart)
      call count_apart(search, center + far*width, search%high(search%highs)%below, apart_too)
      if (apart .and. apart_too) exit
      width = far*width
    end do
  end subroutine gather

  pure logical function is_together(search, k)
    !! Mode k was taken apart with others.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k
    is_together = k >= search%cluster%first .and. k <= search%cluster%last
  end function is_together

  pure logical function is_double(search, k)
    !! Mode k was taken apart from one that has the same frequency to the last digit.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k
    type(dd) :: gap
    integer :: i
    is_double = .false.
    if (.not. is_together(search, k)) return
    do i = search%cluster%first, search%cluster%last
      if (i == k) cycle
      gap = search%cluster%lambda(i - search%cluster%first + 1) - search%cluster%lambda(k - search%cluster%first + 1)
      is_double = is_double .or. abs(gap%hi) <= same*abs(search%cluster%lambda(1)%hi)
    end do
  end function is_double

  pure logical function is_resting(search, k)
    !! λ = 0 for mode k.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k
    is_resting = k > search%growing .and. k <= search%growing + search%resting
  end function is_resting

  subroutine take_resting(search)
    !! The modes of λ = 0.
    type(mode_search), intent(inout) :: search
    associate (first => search%growing + 1, last => search%growing + search%resting)
      if (search%cluster%first == first .and. search%cluster%last == last) return
      call separate(search%system, dd(), first, last, search%probe, search%cluster)
      search%cluster%lambda = dd()
    end associate
  end subroutine take_resting

  pure subroutine take_together(search, k, lambda)
    !! Mode k of those that were taken apart together.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(out) :: lambda
    call take(search%cluster, k, search%system, search%probe)
    lambda = search%probe%frequency%lambda
    search%rough = .true.
  end subroutine take_together

  pure subroutine open_bracket(search, k)
    !! Forget what does not hold mode k.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    do while (search%highs > 0)
      if (search%high(search%highs)%below >= k) exit
      search%low = search%high(search%highs)
      search%highs = search%highs - 1
    end do
    if (search%low%below < k) return
    if (k > search%growing) then
      search%low = separator(dd(), search%growing + search%resting)
    else
      search%low = separator(-search%system%beam%spin_squared, 0)
      search%highs = 1
      search%high(1) = separator(dd(), search%growing)
    end if
  end subroutine open_bracket

  pure subroutine look(search, k, x)
    !! Count the modes below a frequency by a probe of its own, and close the bracket.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    integer :: n
    call probe_at(search%system, x, search%scout)
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
    associate (x => probe%frequency%lambda)
      do c = 1, cuts
        if (best >= regular_enough) exit
        call probe_at(search%finer(c), x, search%finer_probe(c))
        call count_below(search%finer(c), search%finer_probe(c), other, regular)
        if (regular <= best) cycle
        best = regular
        n = other
      end do
      if (n < k) then
        search%low = separator(x, n)
      else
        call push(search, separator(x, n))
      end if
    end associate
  end subroutine count_at

  pure subroutine stands_alone(search, k, lambda, apart)
    !! No other mode is so near that its motion would show in that of mode k by rounding.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: lambda                 !! of mode k, the last that was found
    logical, intent(out) :: apart
    real(dp) :: margin
    type(dd) :: gap
    margin = isolated/mode_density(k, lambda)
    gap = lambda - search%low%lambda
    apart = .not. search%rough
    if (.not. apart) return
    apart = search%low%below == k - 1 .and. gap%hi > margin
    if (.not. apart) call count_apart(search, lambda + (-margin), k - 1, apart)
    if (.not. apart) return
    gap = search%high(search%highs)%lambda - lambda
    if (search%high(search%highs)%below == k .and. gap%hi > margin) return
    call count_apart(search, lambda + margin, k, apart)
  end subroutine stands_alone

  pure subroutine count_apart(search, x, expected, right)
    !! So many modes are below a frequency.
    type(mode_search), intent(inout) :: search
    type(dd), intent(in) :: x
    integer, intent(in) :: expected
    logical, intent(out) :: right
    real(dp) :: regular
    integer :: n
    call probe_at(search%system, x, search%scout)
    call count_below(search%system, search%scout, n, regular)
    right = n == expected
  end subroutine count_apart

  pure subroutine push(search, high)
    type(mode_search), intent(inout) :: search
    type(separator), intent(in) :: high
    type(dd) :: gap
    do while (search%highs > 0)
      gap = search%high(search%highs)%lambda - high%lambda
      if (gap%hi > 0.0_dp) exit
      search%highs = search%highs - 1
    end do
    if (search%highs == depth) then
      search%high(:depth - 1) = search%high(2:)
      search%highs = depth - 1
    end if
    search%highs = search%highs + 1
    search%high(search%highs) = high
  end subroutine push

  pure logical function inside(search, x)
    type(mode_search), intent(in) :: search
    type(dd), intent(in) :: x
    type(dd) :: gap
    gap = x - search%low%lambda
    inside = gap%hi > 0.0_dp
    if (search%highs == 0 .or. .not. inside) return
    gap = search%high(search%highs)%lambda - x
    inside = gap%hi > 0.0_dp
  end function inside

  pure logical function alone(search, k)
    !! The bracket holds mode k and no other.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k
    alone = search%highs > 0 .and. search%low%below == k - 1
    if (alone) alone = search%high(search%highs)%below == k
  end function alone

  pure subroutine certify(search, k, target, least, slope)
    !! Count on both sides of a mode, where that is not known.
    type(mode_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: target
    real(dp), intent(in) :: least, slope           !! margin that is needed; modes to a unit of λ
    real(dp) :: margin
    logical :: known
    type(dd) :: x
    margin = isolated/slope
    known = .false.
    if (search%highs > 0) then
      associate (high => search%high(search%highs))
        x = high%lambda - search%low%lambda
        margin = min(margin, 0.1_dp*x%hi)
        known = high%below == k
      end associate
    end if
    margin = max(margin, least)
    x = target + margin
    if (.not. known .and. inside(search, x)) call look(search, k, x)
    if (alone(search, k)) return
    x = target + (-margin)
    if (inside(search, x)) call look(search, k, x)
  end subroutine certify

  pure type(dd) function middle(search) result(x)
    type(mode_search), intent(in) :: search
    if (search%highs > 0) then
      x = (search%low%lambda + search%high(search%highs)%lambda)*0.5_dp
    else
      x = search%low%lambda*1.1_dp + 1.0_dp
    end if
  end function middle

  pure type(dd) function first_guess(search, k) result(x)
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k
    real(dp) :: start, waves, slope
    start = search%low%lambda%hi
    if (start < 0.0_dp) then
      x = middle(search)
      return
    end if
    waves = 0.0_dp
    if (start > 0.0_dp) then
      call half_waves(search%system%piece, frequency_at(search%system%beam, to_dd(start)), waves, slope)
    else
      start = 1.0_dp
      call half_waves(search%system%piece, frequency_at(search%system%beam, to_dd(start)), waves, slope)
      waves = -0.5_dp
    end if
    x = to_dd(with_half_waves(search, start, waves + (k - search%low%below)))
    if (.not. inside(search, x)) x = middle(search)
  end function first_guess

  pure real(dp) function with_half_waves(search, start, number) result(x)
    !! About where so many half waves fit.
    type(mode_search), intent(in) :: search
    real(dp), intent(in) :: start, number
    real(dp), parameter :: near_enough = 0.05_dp, longest = 4.0_dp
    integer, parameter :: most = 30
    real(dp) :: waves, slope
    integer :: i
    x = start
    do i = 1, most
      call half_waves(search%system%piece, frequency_at(search%system%beam, to_dd(x)), waves, slope)
      if (abs(waves - number) < near_enough) return
      x = x*exp(max(-longest, min(longest, (number - waves)/(slope*x))))
    end do
  end function with_half_waves

  pure type(dd) function next_guess(search, k, n, x, correction, gains) result(guess)
    !! Where inverse iteration points, if that is inside of the bracket and gains; else by the number of half waves or by
    !! halves.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: k, n
    type(dd), intent(in) :: x
    real(dp), intent(in) :: correction
    logical, intent(in) :: gains
    real(dp) :: waves, slope
    guess = x + correction
    if (x%hi <= 0.0_dp .and. .not. (gains .and. inside(search, guess))) guess = middle(search)
    if (x%hi <= 0.0_dp) return
    if ((n == k .or. n == k - 1) .and. gains .and. inside(search, guess)) return
    if (search%highs > 0) then
      guess = middle(search)
      if (abs(n - k) < 4) return
    end if
    call half_waves(search%system%piece, search%probe%frequency, waves, slope)
    guess = to_dd(with_half_waves(search, x%hi, max(0.25_dp*waves, waves + (k - n - 0.5_dp))))
    if (inside(search, guess)) return
    guess = middle(search)
  end function next_guess

end module bw_mode_search
