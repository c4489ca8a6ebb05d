module bw_closed_form
  !! The modes of a uniform clamped beam with a tip mass, rotating without tension: Eqs 7–9 and 18–21.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, operator(*), operator(+), operator(-)
  use bw_frequency_equation, only: solve_root, root_value
  use bw_mode_set, only: mode_set
  use bw_shape, only: shape_type, shape_of, shape_value
  use bw_wave_velocity, only: phase_velocity, group_velocity
  implicit none (type, external)
  private
  public :: closed_form_modes

  type, extends(mode_set), public :: closed_form_set
    real(dp) :: gamma = 0.0_dp                     !! mass ratio γ
    type(shape_type), allocatable :: shape(:)      !! (n)
  contains
    procedure :: shapes => closed_form_shapes
  end type closed_form_set

contains

  pure type(closed_form_set) function closed_form_modes(count, gamma, omega) result(modes)
    !! The first `count` modes; γ = 0 is the beam alone.
    integer, intent(in) :: count           !! ≥ 1
    real(dp), intent(in) :: gamma          !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
      !! in-plane angular velocity in units of h/l²; absent: no rotation acts on the modes
    type(dd), allocatable :: alpha(:), square(:)
    integer :: k
    modes%count = count
    modes%gamma = gamma
    modes%shape = shape_of(solve_root([(k, k=1, count)], gamma))
    modes%alpha = modes%shape%alpha
    modes%tip = modes%shape%tip
    modes%modal_mass = modes%shape%modal_mass
    alpha = root_value(modes%shape%root)
    square = alpha*alpha
    if (present(omega)) then
      modes%beta_squared = (square - omega)*(square + omega)   ! α⁴ − ω² without cancellation, Eq. 2
    else
      modes%beta_squared = square*square                       ! Eq. 3
    end if
    modes%critical_speed = square(1)                           ! ω = hP₁²
    modes%phase_velocity = phase_velocity(modes%alpha, modes%beta_squared)
    modes%group_velocity = group_velocity(modes%alpha, modes%beta_squared)
  end function closed_form_modes

  pure function closed_form_shapes(self, xi) result(values)
    class(closed_form_set), intent(in) :: self
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(self%count, size(xi))
    integer :: p
    do p = 1, size(xi)
      values(:, p) = shape_value(self%shape, xi(p))
    end do
  end function closed_form_shapes

end module bw_closed_form
