module bw_mode_brackets
  !! Brackets of modes: frequencies with known mode counts, on both sides of the wanted mode.
  use bw_double_double, only: dd, operator(+), operator(*)
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: open_for, counted, closed_to, inside, middle, width

  integer, parameter :: depth = 16                 !! upper ends kept for later modes

  type :: separator
    type(dd) :: lambda
    integer :: below = huge(1)                     !! modes below it
  end type separator

  type, public :: mode_bracket
    type(separator) :: low
    type(separator) :: high(depth)                 !! descending
    integer :: highs = 0
  end type mode_bracket

contains

  pure subroutine open_for(bracket, k, growing, up_to_rest, spin_squared)
    !! Drop the ends below mode k, or start anew.
    type(mode_bracket), intent(inout) :: bracket
    integer, intent(in) :: k
    integer, intent(in) :: growing, up_to_rest     !! modes of λ < 0 and of λ ≤ 0
    type(dd), intent(in) :: spin_squared
    do while (bracket%highs > 0)
      if (bracket%high(bracket%highs)%below >= k) exit
      bracket%low = bracket%high(bracket%highs)
      bracket%highs = bracket%highs - 1
    end do
    if (bracket%low%below < k) return
    bracket%highs = 0
    if (k > growing) then
      bracket%low = separator(dd(), up_to_rest)
    else
      bracket%low = separator(spin_squared*(-1.0_dp), 0)
      bracket%highs = 1
      bracket%high(1) = separator(dd(), growing)
    end if
  end subroutine open_for

  pure subroutine counted(bracket, k, lambda, below)
    !! Use a count to narrow the bracket of mode k.
    type(mode_bracket), intent(inout) :: bracket
    integer, intent(in) :: k
    type(dd), intent(in) :: lambda
    integer, intent(in) :: below                   !! modes below λ
    if (below < k .and. gap(lambda, bracket%low%lambda) > 0.0_dp) bracket%low = separator(lambda, below)
    if (below < k) return
    do while (bracket%highs > 0)
      if (gap(bracket%high(bracket%highs)%lambda, lambda) > 0.0_dp) exit
      if (bracket%high(bracket%highs)%below == below) return
      bracket%highs = bracket%highs - 1
    end do
    if (bracket%highs == depth) then
      bracket%high(:depth - 1) = bracket%high(2:)
      bracket%highs = depth - 1
    end if
    bracket%highs = bracket%highs + 1
    bracket%high(bracket%highs) = separator(lambda, below)
  end subroutine counted

  pure logical function closed_to(bracket, below, edge)
    !! Return whether `below` modes lie below the bracket's end beyond a given frequency.
    type(mode_bracket), intent(in) :: bracket
    integer, intent(in) :: below
    type(dd), intent(in) :: edge
    closed_to = bracket%low%below == below .and. gap(edge, bracket%low%lambda) >= 0.0_dp
    if (closed_to .or. bracket%highs == 0) return
    closed_to = bracket%high(bracket%highs)%below == below .and. gap(bracket%high(bracket%highs)%lambda, edge) >= 0.0_dp
  end function closed_to

  pure logical function inside(bracket, x, margin)
    type(mode_bracket), intent(in) :: bracket
    type(dd), intent(in) :: x
    real(dp), intent(in) :: margin                 !! possible error of a count near a mode
    inside = gap(x, bracket%low%lambda) > -margin
    if (bracket%highs == 0 .or. .not. inside) return
    inside = gap(bracket%high(bracket%highs)%lambda, x) > -margin
  end function inside

  pure type(dd) function middle(bracket)
    type(mode_bracket), intent(in) :: bracket
    real(dp) :: step
    if (bracket%highs > 0) then
      middle = (bracket%low%lambda + bracket%high(bracket%highs)%lambda)*0.5_dp
    else
      step = 1.0_dp
      if (bracket%low%lambda%hi > 0.0_dp) step = min(step, bracket%low%lambda%hi)   ! 1 is far away in soft pieces
      middle = bracket%low%lambda*1.1_dp + step
    end if
  end function middle

  pure real(dp) function width(bracket)
    type(mode_bracket), intent(in) :: bracket
    width = huge(width)
    if (bracket%highs > 0) width = gap(bracket%high(bracket%highs)%lambda, bracket%low%lambda)
  end function width

  elemental real(dp) function gap(a, b)
    !! Return a − b of numbers whose difference is exact in binary64 if they are near: their high parts differ by few units.
    type(dd), intent(in) :: a, b
    gap = (a%hi - b%hi) + (a%lo - b%lo)
  end function gap

end module bw_mode_brackets
