module bw_critical_speed
  !! The lowest angular velocity at which a mode of a beam without a closed form is unstable. There β² = 0.
  !!
  !! In the plane of rotation that is K x = Ω²(mass of v) x, rotary inertia having no part; tension keeps every mode stable. Out of
  !! the plane the centrifugal force turns the sections of a beam with shear: without tension v' = ψ, ψ'' + r²Ω²ψ = 0 with
  !! ψ(0) = 0 and ψ'(1) = 0, and Ω = π/(2r), which is (π/2)√(E/ρ)/l for every section and every body at the tip.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_double_double, only: dd, dd_pi, sqrt, to_dd, operator(*), operator(/)
  use bw_strain_modes, only: solve_strain_modes, strain_modes
  use bw_turning_speed, only: turning_speed
  implicit none (type, external)
  private
  public :: critical_speed_of

contains

  type(dd) function critical_speed_of(operator) result(omega)
    !! In h/l²; 0 where there is none: in plane with tension, out of the plane without shear. A beam that does not turn is taken
    !! to bend in plane.
    type(beam_operator), intent(in) :: operator
    omega = dd()
    if (allocated(operator%omega) .and. .not. operator%in_plane) then
      if (.not. allocated(operator%shear)) return
      if (allocated(operator%tension)) then
        omega = to_dd(turning_speed(operator))
      else
        omega = dd_pi*0.5_dp/sqrt(to_dd(operator%shear%rotary))
      end if
    else if (.not. allocated(operator%tension)) then
      omega = speed_in_plane(operator)
    end if
  end function critical_speed_of

  type(dd) function speed_in_plane(operator) result(omega)
    type(beam_operator), intent(in) :: operator
    type(beam_operator) :: still
    type(strain_modes) :: modes
    still = operator
    if (allocated(still%omega)) deallocate (still%omega)
    if (allocated(still%tip_inertia)) deallocate (still%tip_inertia)
    if (allocated(still%shear)) still%shear%rotary = 0.0_dp
    call solve_strain_modes(still, 1, modes)
    omega = to_dd(1.0_dp)/to_dd(modes%period(1))
  end function speed_in_plane

end module bw_critical_speed
