module bw_damping
  !! Damping of modes one by one, q̈ + cq̇ + β²q = 0. The same ratio ζ for every mode: c = 2ζhP². Rayleigh's constants:
  !! c = a + bK/M. K is the elastic stiffness, K/M = (hP²)² where shapes are in closed form: neither the rotation nor the
  !! tension that it brings damps anything.
  use bw_beam_units, only: beam_units
  use bw_damping_par, only: by_ratio, damping_par
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: law_of

  type, public :: damping_law
    !! c = a + 2ζ√λ + bλ with λ = K/M, in the beam's unit of time l²/h.
    real(dp) :: mass = 0.0_dp        !! a
    real(dp) :: ratio = 0.0_dp       !! ζ
    real(dp) :: stiffness = 0.0_dp   !! b
  contains
    procedure :: rates
  end type damping_law

contains

  pure type(damping_law) function law_of(damping, units) result(law)
    !! A damping law without dimensions.
    type(damping_par), intent(in) :: damping
    type(beam_units), intent(in) :: units
    if (by_ratio(damping)) then
      law%ratio = damping%ratio
    else
      law%mass = damping%mass_proportional*units%time%hi
      law%stiffness = damping%stiffness_proportional/units%time%hi
    end if
  end function law_of

  elemental real(dp) function rates(self, elastic) result(c)
    !! c of a mode.
    class(damping_law), intent(in) :: self
    real(dp), intent(in) :: elastic       !! λ = K/M ≥ 0, in (h/l²)²
    c = self%mass + 2.0_dp*self%ratio*sqrt(elastic) + self%stiffness*elastic
  end function rates

end module bw_damping
