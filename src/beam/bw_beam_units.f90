module bw_beam_units
  !! The beam's own units, used in all computations: length l, time l²/h, mass m_i = ρAl.
  !!
  !! If units of length, time and mass change by powers of two, these change by powers of two exactly, so dimensionless
  !! numbers keep their bits.
  use bw_kinds, only: dp, qp
  use bw_beam_par, only: beam_mass, beam_par, second_moment_of, sections_of_beam
  use bw_double_double, only: dd, sqrt, to_dd, operator(*), operator(/)
  use bw_missing, only: scaled
  implicit none (type, external)
  private
  public :: in_joules, in_newton_seconds, slenderness, units_of

  type, public :: beam_units
    real(dp) :: length = 1.0_dp     !! l, m
    real(dp) :: mass = 1.0_dp       !! m_i = ρAl, kg
    type(dd) :: h                   !! h = √(EI/(ρA)), m²/s, Eq. 31
    type(dd) :: time                !! l²/h, s
    real(dp) :: velocity = 1.0_dp   !! h/l, m/s
    real(dp) :: frequency = 1.0_dp  !! h/l², rad/s
  end type beam_units

contains

  pure type(beam_units) function units_of(beam) result(units)
    !! Return the beam's own units from its inputs.
    type(beam_par), intent(in) :: beam
    type(dd) :: length
    length = to_dd(beam%length)
    units%length = beam%length
    units%mass = beam%density*beam%area*beam%length
    if (allocated(beam%pieces)) then
      length = to_dd(sum(real(beam%pieces%length, qp)))
      units%mass = real(beam_mass(beam), dp)
    end if
    units%h = root_of_stiffness(beam)
    units%time = length*length/units%h
    units%velocity = units%h%hi/beam%length
    units%frequency = units%velocity/beam%length
  end function units_of

  pure type(dd) function root_of_stiffness(beam) result(h)
    !! Return h: (D/4)√(E/ρ) for a solid circle, where A and I would only add rounding; else √(E/ρ)√(I/A), with separate
    !! roots, as h² may overflow. Of several pieces that of the root, with the mean of ρA.
    type(beam_par), intent(in) :: beam
    type(dd) :: sound
    if (allocated(beam%pieces)) then
      associate (root => beam%pieces(1))
        h = sqrt(to_dd(root%youngs_modulus*second_moment_of(root)/beam_mass(beam)*sum(real(beam%pieces%length, qp))))
      end associate
      return
    end if
    sound = sqrt(to_dd(beam%youngs_modulus)/to_dd(beam%density))
    if (beam%round) then
      h = sound*to_dd(0.25_dp*beam%diameter)
    else
      h = sound*sqrt(to_dd(beam%second_moment)/to_dd(beam%area))
    end if
  end function root_of_stiffness

  pure real(dp) function slenderness(beam) result(r)
    !! Return r = √(I/A)/l: D/(4l) for a solid circle; the largest of several pieces; 0 if unknown.
    type(beam_par), intent(in) :: beam
    if (beam%is_lumped) then
      r = 0.0_dp
    else if (allocated(beam%pieces)) then
      associate (section => sections_of_beam(beam))
        r = sqrt(maxval(section%second_moment/section%area))/beam%length
      end associate
    else if (beam%round) then
      r = 0.25_dp*beam%diameter/beam%length
    else
      r = sqrt(beam%second_moment/beam%area)/beam%length
    end if
  end function slenderness

  elemental real(dp) function in_newton_seconds(momentum, units, speed) result(value)
    !! Convert a momentum or an impulse from m_i V to N s; missing on overflow.
    real(dp), intent(in) :: momentum
    type(beam_units), intent(in) :: units
    real(dp), intent(in) :: speed               !! V, m/s
    value = scaled(scaled(momentum, speed), units%mass)
  end function in_newton_seconds

  elemental real(dp) function in_joules(energy, units, speed) result(value)
    !! Convert an energy from m_i V² to J; missing on overflow.
    real(dp), intent(in) :: energy
    type(beam_units), intent(in) :: units
    real(dp), intent(in) :: speed               !! V, m/s
    value = scaled(in_newton_seconds(energy, units, speed), speed)
  end function in_joules

end module bw_beam_units
