module bw_turning_speed
  !! The angular velocity at which the sections of a beam turn over out of the plane of rotation, where tension holds them back.
  !!
  !! Out of plane a section that has turned comes nearer the axis: the centrifugal force turns it on, with Ω²r²ψ. At the lowest Ω
  !! at which that is enough β² = 0, and the force equation says that (1 + s²T)v' = ψ. What is left is ψ'' + qψ = 0 with
  !! q = r²Ω² − T/(1 + s²T), ψ(0) = 0, ψ'(1) = 0: a body at the tip has a part in the tension alone. Stiffness less the part of
  !! the rotation is linear in Ω², so that beyond the lowest Ω every other one is unstable too.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  implicit none (type, external)
  private
  public :: turning_speed

  integer, parameter :: steps = 1000           !! 1e-11 of the speed, by comparison with twice as many

  type :: section_equation
    real(dp) :: push = 0.0_dp                    !! w = r²Ω²
    real(dp) :: compliance = 0.0_dp              !! s²
    real(dp) :: hold(3) = 0.0_dp                 !! T/Ω² = h_1 + h_2x + h_3x², x = 1 − ξ, over r²
  end type section_equation

contains

  pure real(dp) function turning_speed(operator) result(omega)
    !! Ω of a beam with shear and tension. **Errors**: 1e-10 relatively.
    type(beam_operator), intent(in) :: operator
    type(section_equation) :: equation
    real(dp) :: low, high
    associate (r2 => operator%shear%rotary, hub => operator%hub_radius)
      equation%compliance = operator%shear%compliance
      equation%hold = [operator%gamma*(1.0_dp + hub), 1.0_dp + hub, -0.5_dp]/r2
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
    !! ψ from 1 at the tip reaches 0 before the root. Steps are finer towards the tip, where T goes to its lowest value.
    type(section_equation), intent(in) :: equation
    real(dp) :: state(2), y, h, finest, reach
    integer :: i
    finest = 1.0_dp + equation%compliance*equation%push*equation%hold(1)
    finest = finest/(equation%compliance*equation%push*equation%hold(2))     ! how far from the tip s²T is as large as there
    reach = log(1.0_dp + 1.0_dp/finest)
    h = reach/steps
    state = [1.0_dp, 0.0_dp]
    turns_over = .true.
    do i = 0, steps - 1
      y = i*h
      state = state + step_of(state, y)
      if (state(1) <= 0.0_dp) return
    end do
    turns_over = .false.
  contains
    pure function step_of(state, y) result(change)
      !! Of Runge and Kutta, in y with x = finest (e^y − 1).
      real(dp), intent(in) :: state(2), y
      real(dp), dimension(2) :: change, a, b, c, d
      a = h*slope(state, y)
      b = h*slope(state + 0.5_dp*a, y + 0.5_dp*h)
      c = h*slope(state + 0.5_dp*b, y + 0.5_dp*h)
      d = h*slope(state + c, y + h)
      change = (a + 2.0_dp*(b + c) + d)/6.0_dp
    end function step_of
    pure function slope(state, y)
      real(dp), intent(in) :: state(2), y
      real(dp) :: slope(2), x, tension
      x = finest*(exp(y) - 1.0_dp)
      tension = equation%push*(equation%hold(1) + x*(equation%hold(2) + x*equation%hold(3)))
      slope = (x + finest)*[state(2), -(equation%push - tension/(1.0_dp + equation%compliance*tension))*state(1)]
    end function slope
  end function turns_over

end module bw_turning_speed
