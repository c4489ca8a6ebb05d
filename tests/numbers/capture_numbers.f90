module capture_numbers
  !! Integrals of two shapes, and the velocities that a capture leaves.
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_impact, only: capture_mass, capture_type, strike
  use bw_kinds, only: dp, qp
  use number_table, only: table_type
  use reference_table, only: column
  implicit none (type, external)
  private
  public :: measure_capture, measure_integrals

contains

  subroutine measure_integrals(table)
    type(table_type), intent(inout) :: table
    real(qp), allocatable :: gamma(:), k(:), i(:), integral(:)
    type(closed_form_set) :: loaded, free
    real(dp), allocatable :: last_alone(:), sums(:)
    integer :: row
    call table%begin('∫Φ_kφ_i dξ, γ = 1e-12 … 1e12, k and i to 2000', 1.0e-13_dp, 'relative')
    gamma = column('cross_integrals.txt', 'gamma')
    k = column('cross_integrals.txt', 'k')
    i = column('cross_integrals.txt', 'i')
    integral = column('cross_integrals.txt', 'integral')
    do row = 1, size(k)
      loaded = closed_form_modes(nint(k(row)), real(gamma(row), dp))
      free = closed_form_modes(nint(i(row)), 0.0_dp)
      last_alone = 0*free%alpha
      last_alone(free%count) = 1
      sums = loaded%overlap(free, last_alone, .false.)
      call table%note(real(abs(sums(loaded%count)/integral(row) - 1), dp))
    end do
  end subroutine measure_integrals

  subroutine measure_capture(table)
    type(table_type), intent(inout) :: table
    real(qp), allocatable :: gamma(:), before(:), after(:), k(:), expected(:), magnitudes(:)
    real(dp), allocatable :: velocity(:)
    logical :: same
    integer :: row
    call table%begin('Eq. 26, γ = 1e-12 … 1e12, 1 to 2000 modes before and after', 1.0e-13_dp, &
                     'part of the sum of the terms'' magnitudes')
    gamma = column('modal_velocities.txt', 'gamma')
    before = column('modal_velocities.txt', 'before')
    after = column('modal_velocities.txt', 'after')
    k = column('modal_velocities.txt', 'k')
    expected = column('modal_velocities.txt', 'modal_velocity')
    magnitudes = column('modal_velocities.txt', 'magnitudes')
    same = .false.
    allocate (velocity(0))
    do row = 1, size(k)
      if (row > 1) same = all([gamma(row) == gamma(row - 1), before(row) == before(row - 1), after(row) == after(row - 1)])
      if (.not. same) velocity = velocities(real(gamma(row), dp), nint(before(row)), nint(after(row)))
      call table%note(real(abs(velocity(nint(k(row))) - expected(row))/magnitudes(row), dp))
    end do
  end subroutine measure_capture

  function velocities(gamma, before, after)
    !! Of all modes after the capture, over the approach velocity.
    real(dp), intent(in) :: gamma
    integer, intent(in) :: before, after
    real(dp), allocatable :: velocities(:)
    type(closed_form_set) :: free
    type(capture_type) :: capture
    free = closed_form_modes(before, 0.0_dp)
    capture = capture_mass(free, strike(free, gamma, 0.0_dp), closed_form_modes(after, gamma))
    velocities = capture%modal_velocity
  end function velocities

end module capture_numbers
