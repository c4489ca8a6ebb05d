module bw_stiffening
  !! The tension that rotation brings into the beam, which stiffens it.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: tension_of

contains

  pure function tension_of(omega, hub_radius, gamma) result(tension)
    !! T(ξ) = Ω²[½(1 − ξ²) + R(1 − ξ) + γ(1 + R)] in EI/l², as t_0 + t_1ξ + t_2ξ².
    real(dp), intent(in) :: omega            !! Ω = |ω|l²/h
    real(dp), intent(in) :: hub_radius       !! R in l
    real(dp), intent(in) :: gamma            !! mass at the tip
    real(dp) :: tension(3)
    tension = omega**2*[0.5_dp + hub_radius + gamma*(1.0_dp + hub_radius), -hub_radius, -0.5_dp]
  end function tension_of

end module bw_stiffening
