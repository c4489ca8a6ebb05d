module bw_damping
  !! Damping of modes one by one, q̈ + cq̇ + β²q = 0. The same ratio ζ for every mode: c = 2ζhP². Rayleigh's constants:
  !! c = a + bK/M. K is the elastic stiffness, K/M = (hP²)² where shapes are in closed form: neither the rotation nor the
  !! tension that it brings damps anything.
  use bw_beam_units, only: beam_units
  use bw_damping_par, only: by_ratio, damping_par
  use bw_double_double, only: dd, to_dd, to_quad, operator(+), operator(*)
  use bw_kinds, only: dp, qp
  implicit none (type, external)
  private
  public :: law_of

  type, public :: damping_law
    !! c = a + 2ζ√λ + bλ with λ = K/M, in the beam's unit of time l²/h.
    real(qp) :: mass = 0.0_qp        !! a
    real(qp) :: ratio = 0.0_qp       !! ζ
    real(qp) :: stiffness = 0.0_qp   !! b
  contains
    procedure :: rates
    procedure :: quarter_squares
  end type damping_law

contains

  pure type(damping_law) function law_of(damping, units) result(law)
    !! A damping law without dimensions.
    type(damping_par), intent(in) :: damping
    type(beam_units), intent(in) :: units
    if (by_ratio(damping)) then
      law%ratio = damping%ratio
    else
      law%mass = damping%mass_proportional*to_quad(units%time)
      law%stiffness = damping%stiffness_proportional/to_quad(units%time)
    end if
  end function law_of

  elemental real(dp) function rates(self, elastic) result(c)
    !! c of a mode.
    class(damping_law), intent(in) :: self
    real(dp), intent(in) :: elastic       !! λ = K/M, in (h/l²)²; what rounding leaves below 0 is 0
    c = real(self%mass, dp) + 2.0_dp*real(self%ratio, dp)*sqrt(max(0.0_dp, elastic)) &
      + real(self%stiffness, dp)*max(0.0_dp, elastic)
  end function rates

  elemental type(dd) function quarter_squares(self, elastic) result(square)
    !! c²/4 of a mode, to all digits of λ: ζ²λ, or ¼(a + bλ)². At and near the critical damping β² − c²/4 has only those that
    !! it has beyond binary64.
    class(damping_law), intent(in) :: self
    type(dd), intent(in) :: elastic       !! λ, in (h/l²)²
    type(dd) :: half
    square = dd(0.25_dp*real(self%mass, dp)**2, 0.0_dp)
    if (elastic%hi < 0.0_dp) return
    if (self%ratio > 0.0_qp) then
      square = to_dd(real(self%ratio, dp))*real(self%ratio, dp)*elastic
    else
      half = to_dd(0.5_dp*real(self%mass, dp)) + elastic*(0.5_dp*real(self%stiffness, dp))
      square = half*half
    end if
  end function quarter_squares

end module bw_damping
