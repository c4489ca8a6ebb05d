module bw_mode_rates
  !! The rates of free modes, without dimensions: how fast a mode turns, and how fast it grows or decays.
  use bw_double_double, only: dd, sqrt, operator(-)
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modal_flow, only: exponent_of
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: find_angular_frequencies, find_growth_rates

contains

  pure subroutine find_angular_frequencies(modes, values)
    !! √(β² − c²/4) in h/l² of the first modes of a set: 0 at the critical speed, missing for a mode that does not turn.
    class(mode_set), intent(in) :: modes
    real(dp), intent(out), contiguous :: values(:)     !! at most as many as the set has
    if (allocated(modes%damping)) then
      call find_roots(modes%damped_squared(:size(values)), values)
    else
      call find_roots(modes%beta_squared(:size(values)), values)
    end if
  end subroutine find_angular_frequencies

  pure subroutine find_roots(squares, roots)
    !! Square roots, missing where there is none.
    type(dd), intent(in) :: squares(:)
    real(dp), intent(out), contiguous :: roots(:)
    type(dd), allocatable :: root(:)
    if (all(squares%hi >= 0.0_dp)) then
      root = sqrt(squares)            ! of a whole list: several times as fast as one by one
      roots = root%hi
    else
      roots = root_of(squares)
    end if
  end subroutine find_roots

  elemental real(dp) function root_of(square)
    !! The square root, missing where there is none.
    type(dd), intent(in) :: square
    type(dd) :: root
    root_of = missing
    if (square%hi < 0.0_dp) return
    root = sqrt(square)
    root_of = root%hi
  end function root_of

  pure subroutine find_growth_rates(modes, values)
    !! The real part of the eigenvalue that decays more slowly, in h/l², of the first modes of a set. Of undamped modes it is
    !! √(−β²) where β² < 0, and 0 elsewhere.
    class(mode_set), intent(in) :: modes
    real(dp), intent(out), contiguous :: values(:)     !! at most as many as the set has
    integer :: n
    n = size(values)
    if (allocated(modes%damping)) then
      associate (rate => exponent_of(modes%beta_squared(:n), modes%damping(:n), modes%damped_squared(:n)))
        values = rate%hi
      end associate
    else
      values = undamped_growth(modes%beta_squared(:n))
    end if
  end subroutine find_growth_rates

  elemental real(dp) function undamped_growth(square) result(rate)
    !! √(−β²) where β² < 0, and 0 elsewhere.
    type(dd), intent(in) :: square              !! β²
    type(dd) :: root
    rate = 0.0_dp
    if (square%hi >= 0.0_dp) return
    root = sqrt(-square)
    rate = root%hi
  end function undamped_growth

end module bw_mode_rates
