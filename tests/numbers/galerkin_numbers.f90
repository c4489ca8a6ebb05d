module galerkin_numbers
  !! Modes without a closed form: against closed forms where there are some, against power series and matrix
  !! exponentials of 40 digits, and how fast more functions make them better.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator, shear_numbers
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_double_double, only: to_dd
  use bw_galerkin, only: galerkin_modes
  use bw_galerkin_set, only: galerkin_set
  use bw_rotation, only: tension_of
  use bw_strain_modes, only: solve_with, strain_modes
  use bw_text, only: text_of
  use number_table, only: table_type
  use reference_table, only: column
  implicit none (type, external)
  private
  public :: measure_galerkin

contains

  subroutine measure_galerkin(table)
    type(table_type), intent(inout) :: table
    call against_closed_form(table)
    call against_references(table, 'tension_modes.txt', 'stiffening by power series, 22 beams: β² + Ω² of modes 1 to 4')
    call against_references(table, 'shear_modes.txt', 'shear by matrix exponentials, 24 beams: β² + Ω² of modes 1 to 6')
    call against_references(table, 'heavy_modes.txt', 'γ to 1e300, J to 1e59, by power series, 67 beams: β² of modes 1 to 5')
    call against_more_functions(table)
    call convergence(table)
  end subroutine measure_galerkin

  subroutine against_closed_form(table)
    type(table_type), intent(inout) :: table
    type(beam_operator) :: operator
    type(galerkin_set) :: set
    type(closed_form_set) :: exact
    real(dp), parameter :: gamma(3) = [0.0_dp, 0.2_dp, 1.0_dp]
    integer :: i
    call table%begin('Galerkin without any effect: β of 200 modes against closed form', 1.0e-13_dp, 'relative')
    do i = 1, size(gamma)
      operator%gamma = gamma(i)
      call galerkin_modes(operator, 200, set)
      exact = closed_form_modes(200, gamma(i))
      call table%note(abs(sqrt(set%beta_squared%hi/exact%beta_squared%hi) - 1))
    end do
  end subroutine against_closed_form

  subroutine against_references(table, file, case)
    type(table_type), intent(inout) :: table
    character(*), intent(in) :: file, case
    type(beam_operator) :: operator
    type(galerkin_set) :: set
    real(dp), allocatable, dimension(:) :: k, square, scale
    integer :: i
    k = of('k')
    square = of('beta_squared')
    scale = abs(square)
    if (file /= 'heavy_modes.txt') scale = square + of('omega')**2
    call table%begin(case, merge(1.0e-12_dp, 1.0e-13_dp, file == 'heavy_modes.txt'), 'relative')
    do i = 1, size(k)
      if (nint(k(i)) == 1) then
        operator = operator_of_row(file, i)
        call galerkin_modes(operator, 6, set)
      end if
      call table%note(abs((set%beta_squared(nint(k(i)))%hi - square(i))/scale(i)))
    end do
  contains
    function of(name) result(values)
      character(*), intent(in) :: name
      real(dp), allocatable :: values(:)
      values = real(column(file, name), dp)
    end function of
  end subroutine against_references

  type(beam_operator) function operator_of_row(file, row) result(operator)
    character(*), intent(in) :: file
    integer, intent(in) :: row
    operator%gamma = at('gamma')
    operator%omega = to_dd(at('omega'))
    operator%in_plane = at('in_plane') > 0
    if (has_tension(file, row)) operator%tension = tension_of(at('omega'), at('hub'), operator%gamma)
    if (at('compliance') > 0) operator%shear = shear_numbers(at('compliance'), at('rotary'))
    if (at('inertia') > 0) operator%tip_inertia = at('inertia')
  contains
    real(dp) function at(name)
      character(*), intent(in) :: name
      real(dp), allocatable :: values(:)
      values = real(column(file, name), dp)
      at = values(row)
    end function at
  end function operator_of_row

  logical function has_tension(file, row)
    character(*), intent(in) :: file
    integer, intent(in) :: row
    real(dp), allocatable :: tension(:)
    has_tension = file == 'tension_modes.txt'
    if (file /= 'heavy_modes.txt') return
    tension = real(column(file, 'tension'), dp)
    has_tension = tension(row) > 0
  end function has_tension

  subroutine against_more_functions(table)
    !! Speeds within linear theory, Ωr ≤ 0.1, r = D/(4l).
    type(table_type), intent(inout) :: table
    real(dp), parameter :: omega(6) = [0.0_dp, 1000.0_dp, 0.0_dp, 1000.0_dp, 10.0_dp, 0.8_dp]
    real(dp), parameter :: slenderness(6) = [0.0_dp, 0.0_dp, 1e-6_dp, 1e-6_dp, 0.037_dp, 0.5_dp]   ! 0: no shear
    integer :: i
    call table%begin('200 modes, Ω = 0 … 1000, D/l = 1e-6 … 0.5, without and with shear: β against 1.4 times the functions', &
                     1.0e-10_dp, 'relative')
    do i = 1, size(omega)
      call note_change(table, omega(i), slenderness(i)/4)
    end do
  end subroutine against_more_functions

  subroutine note_change(table, omega, r)
    type(table_type), intent(inout) :: table
    real(dp), intent(in) :: omega
    real(dp), intent(in) :: r                 !! 0: no shear
    type(beam_operator) :: operator
    type(galerkin_set) :: set
    type(strain_modes) :: finer
    operator%gamma = 0.2_dp
    operator%omega = to_dd(omega)
    operator%tension = tension_of(omega, 0.3_dp, 0.2_dp)
    if (r > 0) operator%shear = shear_numbers(3*r**2, r**2)
    call galerkin_modes(operator, 200, set)
    call solve_with(operator, 200, (14*(size(set%deflection, 1) - 2))/10, finer)
    call table%note(abs(finer%period*sqrt(set%beta_squared%hi + finer%system%shift%hi) - 1))
  end subroutine note_change

  subroutine convergence(table)
    type(table_type), intent(inout) :: table
    integer, parameter :: functions(5) = [12, 16, 20, 24, 28]
    real(dp), parameter :: bounds(5) = [0.5_dp, 3e-3_dp, 5e-6_dp, 2e-9_dp, 1e-13_dp]
    type(beam_operator) :: operator
    type(strain_modes) :: exact, some
    integer :: i
    operator%gamma = 0.2_dp
    operator%omega = to_dd(50.0_dp)
    operator%tension = tension_of(50.0_dp, 0.0_dp, 0.2_dp)
    call solve_with(operator, 10, 80, exact)
    do i = 1, size(functions)
      call table%begin('stiffening at Ω = 50: β of mode 10 in '//text_of(functions(i))//' functions', bounds(i), 'relative')
      call solve_with(operator, 10, functions(i), some)
      call table%note(abs(exact%period(10)/some%period(10) - 1))
    end do
  end subroutine convergence

end module galerkin_numbers
