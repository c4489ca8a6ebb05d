module bw_modal_values
  !! What a result holds of each mode, in SI units.
  use bw_case_result, only: case_result
  use bw_double_double, only: dd, sqrt, operator(-)
  use bw_kinds, only: dp
  use bw_missing, only: missing, scaled
  use bw_modal_flow, only: exponent_of
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: put_modal

  character(*), parameter, public :: modal_names(*) = [character(17) :: 'alpha', 'wavenumber', 'angular_frequency', &
    'growth_rate', 'modal_mass', 'modal_velocity', 'phase_velocity', 'group_velocity']

contains

  pure subroutine put_modal(result, modes, modal_velocity, what, values)
    !! The values of the first modes of a set, in SI units.
    type(case_result), intent(in) :: result                 !! whose units these are
    class(mode_set), intent(in) :: modes
    real(dp), intent(in), optional :: modal_velocity(:)     !! of these modes, in V; absent: nothing strikes the beam
    integer, intent(in) :: what
    real(dp), intent(out), contiguous :: values(:)
    integer :: n
    n = size(values)
    associate (units => result%units)
      select case (what)          ! by places in modal_names
      case (1); values = modes%alpha(:n)
      case (2); values = modes%alpha(:n)/units%length
      case (3); call put_frequency(modes, units%frequency, values)
      case (4); call put_growth_rate(modes, units%frequency, values)
      case (5); values = modes%modal_mass(:n)*units%mass
      case (6); values = modal_velocity(:n)*result%approach_velocity
      case (7); values = scaled(modes%phase_velocity(:n), units%velocity)
      case default; values = scaled(modes%group_velocity(:n), units%velocity)
      end select
    end associate
  end subroutine put_modal

  pure subroutine put_frequency(modes, unit, values)
    !! √(β² − c²/4) where it is real, 0 at the critical speed.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: unit
    real(dp), intent(out), contiguous :: values(:)
    if (allocated(modes%damping)) then
      call put_roots(modes%damped_squared, unit, values)
    else
      call put_roots(modes%beta_squared, unit, values)
    end if
  end subroutine put_frequency

  pure subroutine put_roots(square, unit, values)
    !! Roots, missing where there is none.
    type(dd), intent(in) :: square(:)
    real(dp), intent(in) :: unit
    real(dp), intent(out), contiguous :: values(:)
    type(dd), allocatable :: root(:)
    if (all(square%hi >= 0.0_dp)) then
      root = sqrt(square)             ! of a whole list: a few times as fast
      values = root%hi*unit
    else
      values = scaled(frequency_of(square), unit)
    end if
  end subroutine put_roots

  pure subroutine put_growth_rate(modes, unit, values)
    !! The real part of the slower eigenvalue; of undamped modes |β| where β² < 0, and 0 elsewhere.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: unit
    real(dp), intent(out), contiguous :: values(:)
    if (allocated(modes%damping)) then
      associate (rate => exponent_of(modes%beta_squared, modes%damping, modes%damped_squared))
        values = rate%hi*unit
      end associate
    else
      values = growth_of(modes%beta_squared)*unit
    end if
  end subroutine put_growth_rate

  elemental real(dp) function growth_of(square) result(rate)
    type(dd), intent(in) :: square
    type(dd) :: root
    rate = 0.0_dp
    if (square%hi >= 0.0_dp) return
    root = sqrt(-square)
    rate = root%hi
  end function growth_of

  elemental real(dp) function frequency_of(square) result(beta)
    type(dd), intent(in) :: square
    type(dd) :: root
    beta = missing
    if (square%hi < 0.0_dp) return
    root = sqrt(square)
    beta = root%hi
  end function frequency_of

end module bw_modal_values
