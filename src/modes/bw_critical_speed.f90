module bw_critical_speed
  !! The lowest angular velocity at which a mode of a beam without tension is unstable, in the plane of rotation.
  !!
  !! There β² = 0, so that rotary inertia has no part: K x = Ω²(mass of v) x.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_double_double, only: dd, to_dd, operator(/)
  use bw_strain_modes, only: solve_strain_modes, strain_modes
  implicit none (type, external)
  private
  public :: critical_speed_of

contains

  type(dd) function critical_speed_of(operator) result(omega)
    !! In h/l²; 0 where there is none: with tension, or out of the plane.
    type(beam_operator), intent(in) :: operator
    type(beam_operator) :: still
    type(strain_modes) :: modes
    omega = to_dd(0.0_dp)
    if (allocated(operator%tension)) return
    if (allocated(operator%omega) .and. .not. operator%in_plane) return
    still = operator
    if (allocated(still%omega)) deallocate (still%omega)
    if (allocated(still%tip_inertia)) deallocate (still%tip_inertia)
    if (allocated(still%shear)) still%shear%rotary = 0.0_dp
    call solve_strain_modes(still, 1, modes)
    omega = to_dd(1.0_dp)/to_dd(modes%period(1))
  end function critical_speed_of

end module bw_critical_speed
