module bw_extended_modes
  !! Modes that binary64 does not tell apart or does not find, in binary128: the count of modes encloses mode k alone, and inverse
  !! iteration goes to it.
  use bw_double_double, only: dd, operator(+), operator(-), operator(*)
  use bw_extended_probe, only: count_at, extended_probe, improve, open_probe, start, uncounted
  use bw_kinds, only: dp
  use bw_mode_cluster, only: find_cluster, find_resting, keep_alone, mode_cluster
  use bw_piece_beam, only: piece_beam
  implicit none (type, external)
  private
  public :: find_extended, find_at_rest

  real(dp), parameter :: cluster_width = 1.0e-15_dp    !! of λ
  real(dp), parameter :: count_error = 1.0e-17_dp  !! of λ: where a count may be off, two pivots in a row nearly vanishing
  real(dp), parameter :: settled = 1.0e-28_dp      !! a step, of λ
  integer, parameter :: most_stays = 3             !! steps that do not get smaller: they are rounding
  integer, parameter :: most_steps = 400

  type, public :: extended_search
    type(extended_probe) :: probe
    type(dd) :: low, high                          !! frequencies on both sides of the mode
    integer :: below_low = 0, below_high = 0       !! modes below them
    type(mode_cluster) :: cluster                  !! the modes that were found last
  end type extended_search

contains

  subroutine find_extended(search, beam, k, guess, distance, found)
    !! Mode k, and with it its cluster.
    type(extended_search), intent(inout) :: search
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: k
    type(dd), intent(in) :: guess                  !! about its λ
    real(dp), intent(in) :: distance               !! to the next, about
    logical, intent(out) :: found
    type(dd) :: x, next
    real(dp) :: correction, before
    integer :: i, stays
    logical :: alone, inside, gains
    stays = 0
    call open_probe(search%probe, beam)
    call enclose(search, k, guess, distance, found)
    if (.not. found) return
    x = guess
    before = huge(before)
    do i = 1, most_steps
      alone = search%below_low == k - 1 .and. search%below_high == k
      if (.not. alone) then
        if (gap(search%high, search%low) < cluster_width*abs(search%high%hi)) exit
        x = middle(search)
        call step_to(search, k, x)
        before = huge(before)
        cycle
      end if
      call step_to(search, k, x)
      if (before == huge(before)) call start(search%probe, 1)
      call improve(search%probe, correction)
      next = x + correction
      inside = min(gap(next, search%low), gap(search%high, next)) > -max(count_error*abs(x%hi), search%probe%error)
      gains = abs(correction) < 0.5_dp*before
      if ((inside .and. abs(correction) < settled*abs(x%hi)) .or. &
          (stays > most_stays .and. abs(correction) < search%probe%error)) then
        call keep_mode(search, k, next)
        return
      end if
      if (.not. (inside .and. gains)) stays = stays + 1
      x = next
      if (.not. inside .or. (mod(stays, 2) == 0 .and. .not. gains)) x = middle(search)
      before = abs(correction)
    end do
    found = i <= most_steps .and. search%below_high < uncounted
    if (found) call find_cluster(search%probe, search%below_low + 1, search%below_high, middle(search), search%cluster)
  end subroutine find_extended

  pure subroutine find_at_rest(search, beam, first, last)
    !! Modes of which it is known that λ = 0.
    type(extended_search), intent(inout) :: search
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: first, last             !! their numbers
    call open_probe(search%probe, beam)
    call find_resting(search%probe, beam, first, last, search%cluster)
  end subroutine find_at_rest

  pure subroutine enclose(search, k, guess, distance, found)
    !! Count on both sides, further away until mode k is between.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: guess
    real(dp), intent(in) :: distance
    logical, intent(out) :: found
    integer, parameter :: most = 100
    type(dd) :: edge
    real(dp) :: margin
    integer :: i, n
    search%below_low = -1
    search%below_high = -1
    margin = distance
    if (guess%hi > 0.0_dp) margin = min(margin, guess%hi)      ! modes of very soft pieces lie far closer
    do i = 1, most
      found = search%below_low >= 0 .and. search%below_high >= 0
      if (found) return
      if (search%below_low < 0) then
        edge = guess + (-margin)
        if (guess%hi > 0.0_dp) edge = guess*(1.0_dp/(1.0_dp + margin/guess%hi))    ! above 0
        call count_at(search%probe, edge, n)
        if (n < k) call set_low(search, edge, n)
        if (n >= k) call set_high(search, edge, n)
      end if
      if (search%below_high < 0) then
        edge = guess + margin
        call count_at(search%probe, edge, n)
        if (n >= k) call set_high(search, edge, n)
        if (n < k) call set_low(search, edge, n)
      end if
      margin = 2.0_dp*margin
    end do
  end subroutine enclose

  pure subroutine set_low(search, x, below)
    type(extended_search), intent(inout) :: search
    type(dd), intent(in) :: x
    integer, intent(in) :: below
    search%low = x
    search%below_low = below
  end subroutine set_low

  pure subroutine set_high(search, x, below)
    type(extended_search), intent(inout) :: search
    type(dd), intent(in) :: x
    integer, intent(in) :: below
    search%high = x
    search%below_high = below
  end subroutine set_high

  pure subroutine step_to(search, k, x)
    !! Set up a frequency; its count encloses mode k more closely.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    integer :: n
    call count_at(search%probe, x, n)
    if (n < k .and. gap(x, search%low) > 0.0_dp) call set_low(search, x, n)
    if (n >= k .and. gap(search%high, x) > 0.0_dp) call set_high(search, x, n)
  end subroutine step_to

  subroutine keep_mode(search, k, lambda)
    !! Mode k, unless others are so near that they are a cluster.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: lambda
    real(dp) :: correction
    integer :: first, last, n
    call count_at(search%probe, lambda*(1.0_dp - cluster_width), first)
    call count_at(search%probe, lambda*(1.0_dp + cluster_width), last)
    first = min(first + 1, k)
    last = max(last, k)
    if (last > first) then
      call find_cluster(search%probe, first, last, lambda, search%cluster)
      return
    end if
    call count_at(search%probe, lambda, n)
    call improve(search%probe, correction)               ! once more: the motion lags behind the frequency
    call keep_alone(search%probe, k, lambda, search%cluster)
  end subroutine keep_mode

  pure type(dd) function middle(search)
    type(extended_search), intent(in) :: search
    middle = (search%low + search%high)*0.5_dp
  end function middle

  pure real(dp) function gap(a, b)
    !! a − b.
    type(dd), intent(in) :: a, b
    type(dd) :: difference
    difference = a - b
    gap = difference%hi
  end function gap

end module bw_extended_modes
