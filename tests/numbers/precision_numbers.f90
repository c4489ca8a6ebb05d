module precision_numbers
  !! Extended precision is entered where binary64 cannot carry a root, and costs nothing elsewhere.
  use bw_kinds, only: dp
  use bw_beam_units, only: beam_units, units_of
  use bw_refined_root, only: is_coarse
  use bw_double_double, only: dd, to_dd, operator(*)
  use bw_frequency_equation, only: root_type, root_value, solve_root
  use number_table, only: table_type
  use paper_motion, only: paper_beam
  implicit none (type, external)
  private
  public :: measure_extended_precision

  integer, parameter :: modes = 10000

contains

  subroutine measure_extended_precision(table)
    !! The paper's beam over 1 s, free and with masses, at rest and at 50 rad/s.
    type(table_type), intent(inout) :: table
    real(dp), parameter :: mass_ratios(4) = [0.0_dp, 0.2_dp, 1.0_dp, 1.0e6_dp]
    type(beam_units) :: units
    type(root_type), allocatable :: root(:)
    type(dd) :: omega
    type(dd), allocatable :: alpha(:)
    integer :: g, k
    units = units_of(paper_beam())
    omega = to_dd(50.0_dp)*units%time
    call table%begin('extended precision in scenes that need none: 10⁴ modes over 1 s', 0.0_dp, 'roots solved again')
    do g = 1, size(mass_ratios)
      root = solve_root([(k, k=1, modes)], mass_ratios(g))
      alpha = root_value(root)
      call table%note(merge(1.0_dp, 0.0_dp, is_coarse(root%remainder, alpha%hi, longest=1.0_dp/units%time%hi)))
      call table%note(merge(1.0_dp, 0.0_dp, is_coarse(root%remainder, alpha%hi, omega, 1.0_dp/units%time%hi)))
    end do
  end subroutine measure_extended_precision

end module precision_numbers
