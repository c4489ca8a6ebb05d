module bw_critical_speed
  !! The lowest angular velocity at which a mode of a beam without a closed form is unstable. There β² = 0.
  !!
  !! In the plane of rotation that is K x = Ω²(mass of v) x, rotary inertia having no part; tension keeps every mode stable. Out of
  !! the plane the centrifugal force turns the sections of a beam with shear, with Ω²r²ψ: a section that has turned comes nearer
  !! the axis. Without tension v' = ψ, ψ'' + r²Ω²ψ = 0 with ψ(0) = 0 and ψ'(1) = 0, and Ω = π/(2r), which is (π/2)√(E/ρ)/l for
  !! every section and every body at the tip. With tension the force equation says that (1 + s²T)v' = ψ, and what is left is
  !! ψ'' + qψ = 0 with q = r²Ω² − T/(1 + s²T) and the same ends: a body at the tip has a part in the tension alone. Stiffness less
  !! the part of the rotation is linear in Ω², so that beyond the lowest Ω every other one is unstable too.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_double_double, only: dd, dd_pi, sqrt, to_dd, operator(*), operator(/)
  use bw_strain_modes, only: solve_strain_modes, strain_modes
  implicit none (type, external)
  private
  public :: critical_speed_of

  integer, parameter :: steps = 1000           !! 1e-11 of the speed, by comparison with twice as many

  type :: section_equation
    !! What q depends on.
    real(dp) :: push = 0.0_dp                    !! w = r²Ω²
    real(dp) :: compliance = 0.0_dp              !! s²
    real(dp) :: pull(3) = 0.0_dp                 !! T/(r²Ω²) = h_1 + h_2x + h_3x², x = 1 − ξ
  end type section_equation

contains

  type(dd) function critical_speed_of(operator) result(omega)
    !! The critical speed in h/l²; 0 where there is none: in plane with tension, out of the plane without shear. A beam that
    !! does not turn is taken to bend in plane.
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
    !! Ω of a beam without tension: its lowest frequency where rotary inertia is left out.
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

  pure real(dp) function turning_speed(operator) result(omega)
    !! Ω at which the sections of a beam with shear and tension turn over out of the plane, by bisection.
    !! **Errors**: 1e-10 relatively.
    type(beam_operator), intent(in) :: operator
    type(section_equation) :: equation
    real(dp) :: low, high
    associate (r2 => operator%shear%rotary, hub => operator%hub_radius)
      equation%compliance = operator%shear%compliance
      equation%pull = [operator%gamma*(1.0_dp + hub), 1.0_dp + hub, -0.5_dp]/r2
      low = 0.0_dp
      high = 0.25_dp*acos(-1.0_dp)**2 + 1.0_dp/operator%shear%compliance     ! v' = 0: shear alone holds the sections
      do
        equation%push = 0.5_dp*(low + high)
        if (equation%push <= low .or. equation%push >= high) exit
        if (turns_over(equation)) then
          high = equation%push
        else
          low = equation%push
        end if
      end do
      omega = sqrt(high/r2)
    end associate
  end function turning_speed

  pure logical function turns_over(equation)
    !! Whether ψ from 1 at the tip reaches 0 before the root. Steps are finer towards the tip, where T goes to its lowest value.
    type(section_equation), intent(in) :: equation
    real(dp) :: state(2), y, h, finest, reach
    integer :: i
    finest = 1.0_dp + equation%compliance*equation%push*equation%pull(1)
    finest = finest/(equation%compliance*equation%push*equation%pull(2))     ! how far from the tip s²T is as large as there
    reach = log(1.0_dp + 1.0_dp/finest)
    h = reach/steps
    state = [1.0_dp, 0.0_dp]
    turns_over = .true.
    do i = 0, steps - 1
      y = i*h
      if (state(2) >= 0.0_dp .and. push_at(place(y)) <= 0.0_dp) exit       ! T rises towards the root: from here on ψ grows
      state = state + step_of(state, y)
      if (state(1) <= 0.0_dp) return
    end do
    turns_over = .false.
  contains
    pure function step_of(state, y) result(change)
      !! The change of ψ and −dψ/dξ in one step of Runge and Kutta, in y with x = finest (e^y − 1).
      real(dp), intent(in) :: state(2), y
      real(dp), dimension(2) :: change, a, b, c, d
      a = h*slope(state, y)
      b = h*slope(state + 0.5_dp*a, y + 0.5_dp*h)
      c = h*slope(state + 0.5_dp*b, y + 0.5_dp*h)
      d = h*slope(state + c, y + h)
      change = (a + 2.0_dp*(b + c) + d)/6.0_dp
    end function step_of
    pure function slope(state, y)
      !! The derivative of ψ and −dψ/dξ by y.
      real(dp), intent(in) :: state(2), y
      real(dp) :: slope(2), x
      x = place(y)
      slope = (x + finest)*[state(2), -push_at(x)*state(1)]
    end function slope
    pure real(dp) function place(y) result(x)
      !! x = 1 − ξ.
      real(dp), intent(in) :: y
      x = finest*(exp(y) - 1.0_dp)
    end function place
    pure real(dp) function push_at(x) result(q)
      !! q = w − T/(1 + s²T).
      real(dp), intent(in) :: x
      real(dp) :: tension
      tension = equation%push*(equation%pull(1) + x*(equation%pull(2) + x*equation%pull(3)))
      q = equation%push - tension/(1.0_dp + equation%compliance*tension)
    end function push_at
  end function turns_over

end module bw_critical_speed
