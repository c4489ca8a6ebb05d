module galerkin_numbers
  !! Modes without a closed form: against closed forms where there are some, against power series and matrix
  !! exponentials of 40 digits, and how fast more functions make them better.
  use bw_kinds, only: dp
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_strain_modes, only: modes_with
  use bw_strain_set, only: strain_set
  use bw_text, only: text_of
  use bw_varying_beam, only: varying_beam
  use number_table, only: table_type
  use reference_table, only: column
  use rotating_beams, only: beam_of_row, first_modes, reference_row, stiffened, unstiffened
  implicit none (type, external)
  private
  public :: measure_galerkin

contains

  subroutine measure_galerkin(table)
    type(table_type), intent(inout) :: table
    call against_closed_form(table)
    call against_references(table, 'tension_modes.txt', 'stiffening by power series, 22 beams: β² + Ω² of modes 1 to 4')
    call against_references(table, 'shear_modes.txt', 'shear by matrix exponentials, 24 beams: β² + Ω² of modes 1 to 6')
    call against_references(table, 'heavy_modes.txt', 'stiffening with γ to 1e12, by power series, 14 beams: β² of modes 1 to 5')
    call against_more_functions(table)
    call convergence(table)
  end subroutine measure_galerkin

  subroutine against_closed_form(table)
    type(table_type), intent(inout) :: table
    type(strain_set), allocatable :: set
    type(closed_form_set) :: exact
    real(dp), parameter :: gamma(3) = [0.0_dp, 0.2_dp, 1.0_dp]
    integer :: i
    call table%begin('Galerkin without any effect: β of 200 modes against closed form', 1.0e-13_dp, 'relative')
    do i = 1, size(gamma)
      set = first_modes(unstiffened(0.0_dp, gamma(i), .true.), 200)
      exact = closed_form_modes(200, gamma(i))
      call table%note(abs(sqrt(set%beta_squared%hi/exact%beta_squared%hi) - 1))
    end do
  end subroutine against_closed_form

  subroutine against_references(table, file, case)
    type(table_type), intent(inout) :: table
    character(*), intent(in) :: file, case
    type(reference_row) :: row
    type(strain_set), allocatable :: set
    integer :: i
    call table%begin(case, merge(1.0e-12_dp, 1.0e-13_dp, file == 'heavy_modes.txt'), 'relative')
    do i = 1, size(column(file, 'k'))
      row = beam_of_row(file, i)
      if (file == 'heavy_modes.txt' .and. .not. row%is_pulled) cycle      ! modes of pieces
      if (row%k == 1) set = first_modes(row%beam, 6)
      if (file == 'heavy_modes.txt') row%spin = 0.0_dp
      call table%note(abs((set%beta_squared(row%k)%hi - row%square)/(abs(row%square) + row%spin)))
    end do
  end subroutine against_references

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
    type(varying_beam) :: beam
    type(strain_set), allocatable :: set
    type(strain_set) :: finer
    real(dp) :: last
    beam = stiffened(omega, 0.3_dp, 0.2_dp, .false., 3*r**2, r**2)
    set = first_modes(beam, 200)
    call modes_with(beam, 200, [(14*(size(set%piece(1)%turning, 1) - 1))/10], 1, finer, last)
    call table%note(abs(sqrt(finer%beta_squared%hi/set%beta_squared%hi) - 1))
  end subroutine note_change

  subroutine convergence(table)
    type(table_type), intent(inout) :: table
    integer, parameter :: functions(5) = [12, 16, 20, 24, 28]
    real(dp), parameter :: bounds(5) = [0.5_dp, 3e-3_dp, 5e-6_dp, 2e-9_dp, 1e-13_dp]
    type(strain_set) :: exact, some
    real(dp) :: last
    integer :: i
    call modes_with(stiffened(50.0_dp, 0.0_dp, 0.2_dp, .false.), 10, [80], 1, exact, last)
    do i = 1, size(functions)
      call table%begin('stiffening at Ω = 50: β of mode 10 in '//text_of(functions(i))//' functions', bounds(i), 'relative')
      call modes_with(stiffened(50.0_dp, 0.0_dp, 0.2_dp, .false.), 10, [functions(i)], 1, some, last)
      call table%note(abs(sqrt(exact%beta_squared(10)%hi/some%beta_squared(10)%hi) - 1))
    end do
  end subroutine convergence

end module galerkin_numbers
