module dispersion_numbers
  !! Frequencies and wave velocities around the critical angular velocity of each mode, where η = ω/(hP²) = 1.
  use bw_kinds, only: dp, qp
  use bw_beam_units, only: beam_units, units_of
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_double_double, only: dd, sqrt, to_dd, operator(*), operator(-)
  use number_table, only: table_type
  use paper_motion, only: paper_beam
  use reference_table, only: column
  implicit none (type, external)
  private
  public :: measure_dispersion

contains

  subroutine measure_dispersion(table)
    type(table_type), intent(inout) :: table
    type(beam_units) :: units
    units = units_of(paper_beam())
    call measure_frequencies(table, units)
    call measure_velocities(table, units)
  end subroutine measure_dispersion

  subroutine measure_frequencies(table, units)
    !! The square's sign is part of the number: growth where it is negative.
    type(table_type), intent(inout) :: table
    type(beam_units), intent(in) :: units
    real(qp), allocatable :: gamma(:), k(:), omega(:), square(:), beta(:)
    type(closed_form_set) :: modes
    type(dd) :: root
    integer :: i
    call table%begin('β or growth rate at η = 1 ± 10⁻ᵏ, k = 1 … 15, and next to 1', 1.0e-12_dp, 'relative')
    gamma = column('frequencies.txt', 'gamma')
    k = column('frequencies.txt', 'k')
    omega = column('frequencies.txt', 'omega')
    square = column('frequencies.txt', 'beta_squared')
    beta = column('frequencies.txt', 'beta')
    do i = 1, size(k)
      modes = closed_form_modes(nint(k(i)), real(gamma(i), dp), to_dd(real(omega(i), dp))*units%time)
      root = modes%beta_squared(nint(k(i)))
      if (square(i) < 0) root = -root
      root = sqrt(root)
      call table%note(real(abs(root%hi*units%frequency/beta(i) - 1), dp))
    end do
  end subroutine measure_frequencies

  subroutine measure_velocities(table, units)
    type(table_type), intent(inout) :: table
    type(beam_units), intent(in) :: units
    real(qp), allocatable :: gamma(:), k(:), omega(:)
    real(dp), allocatable :: phase(:), group(:)
    type(closed_form_set) :: modes
    integer :: i
    gamma = column('wave_velocities.txt', 'gamma')
    k = column('wave_velocities.txt', 'k')
    omega = column('wave_velocities.txt', 'omega')
    allocate (phase(size(k)), group(size(k)))
    do i = 1, size(k)
      modes = closed_form_modes(nint(k(i)), real(gamma(i), dp), to_dd(real(omega(i), dp))*units%time)
      phase(i) = modes%phase_velocity(modes%count)*units%velocity
      group(i) = modes%group_velocity(modes%count)*units%velocity
    end do
    call table%begin('phase velocity at those η', 1.0e-12_dp, 'relative')
    call table%note(real(abs(phase/column('wave_velocities.txt', 'phase_velocity') - 1), dp))
    call table%begin('group velocity at those η', 1.0e-12_dp, 'relative')
    call table%note(real(abs(group/column('wave_velocities.txt', 'group_velocity') - 1), dp))
  end subroutine measure_velocities

end module dispersion_numbers
