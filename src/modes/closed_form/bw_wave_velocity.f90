module bw_wave_velocity
  !! Phase and group velocity of a mode of a uniform beam without tension, Eqs 32 and 33, without dimensions:
  !! lengths in l, times in l²/h, velocities in h/l.
  use bw_kinds, only: dp
  use bw_double_double, only: dd
  use bw_missing, only: missing
  implicit none (type, external)
  private
  public :: phase_velocity, group_velocity

contains

  elemental real(dp) function phase_velocity(alpha, beta_squared) result(velocity)
    !! C_p = β/P (Eq. 32); missing for an unstable mode, 0 at its critical speed.
    real(dp), intent(in) :: alpha           !! wave number P l > 0
    type(dd), intent(in) :: beta_squared    !! β² = α⁴ − ω², in (h/l²)²
    velocity = missing
    if (beta_squared%hi < 0.0_dp) return
    velocity = sqrt(beta_squared%hi)/alpha
  end function phase_velocity

  elemental real(dp) function group_velocity(alpha, beta_squared) result(velocity)
    !! C_g = dβ/dP = 2α³/β (Eq. 33); missing for an unstable mode and at its critical speed.
    real(dp), intent(in) :: alpha
    type(dd), intent(in) :: beta_squared
    velocity = missing
    if (beta_squared%hi <= 0.0_dp) return
    velocity = 2.0_dp*alpha*(alpha**2/sqrt(beta_squared%hi))
  end function group_velocity

end module bw_wave_velocity
