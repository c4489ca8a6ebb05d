module bw_damping
  !! Modal damping, q̈ + cq̇ + β²q = 0. One damping ratio ζ for all modes: c = 2ζhP². Rayleigh damping: c = a + bK/M,
  !! with the elastic stiffness K, K/M = (hP²)² for shapes in closed form; neither rotation nor its tension contributes.
  use bw_beam_units, only: beam_units
  use bw_damping_par, only: by_ratio, damping_par
  use bw_double_double, only: dd, to_dd, operator(+), operator(*)
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
    procedure :: quarter_squares
  end type damping_law

contains

  pure type(damping_law) function law_of(damping, units) result(law)
    !! Return the damping law without dimensions.
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
    !! Return c of a mode.
    class(damping_law), intent(in) :: self
    real(dp), intent(in) :: elastic       !! λ = K/M, in (h/l²)²; values below 0, due to rounding, count as 0
    c = self%mass + 2.0_dp*self%ratio*sqrt(max(0.0_dp, elastic)) + self%stiffness*max(0.0_dp, elastic)
  end function rates

  elemental type(dd) function quarter_squares(self, elastic) result(square)
    !! Return c²/4 of a mode to all digits of λ: ζ²λ, or ¼(a + bλ)². Near critical damping β² − c²/4 has only the digits
    !! beyond binary64.
    class(damping_law), intent(in) :: self
    type(dd), intent(in) :: elastic       !! λ, in (h/l²)²
    type(dd) :: half
    square = dd(0.25_dp*self%mass**2, 0.0_dp)
    if (elastic%hi < 0.0_dp) return
    if (self%ratio > 0.0_dp) then
      square = to_dd(self%ratio)*self%ratio*elastic
    else
      half = to_dd(0.5_dp*self%mass) + elastic*(0.5_dp*self%stiffness)
      square = half*half
    end if
  end function quarter_squares

end module bw_damping
