module shape_numbers
  !! Roots, shapes and modal masses for every mode number and mass ratio.
  use bw_kinds, only: dp, qp
  use bw_double_double, only: dd
  use bw_frequency_equation, only: root_value, solve_root
  use bw_shape, only: shape_of, shape_type, shape_value
  use number_table, only: table_type
  use reference_table, only: column
  implicit none (type, external)
  private
  public :: measure_modal_quantities, measure_roots, measure_shapes

contains

  subroutine measure_roots(table)
    type(table_type), intent(inout) :: table
    real(qp), allocatable :: gamma(:), k(:), alpha(:)
    type(dd) :: root
    integer :: i
    call table%begin('α_k, k = 1 … 10⁸, γ = 0, 1e-300 … 1e300', 2.0_dp, 'units in the last place')
    gamma = column('roots.txt', 'gamma')
    k = column('roots.txt', 'k')
    alpha = column('roots.txt', 'alpha')
    do i = 1, size(alpha)
      root = root_value(solve_root(nint(k(i)), real(gamma(i), dp)))
      call table%note(real(abs(root%hi - alpha(i))/spacing(real(alpha(i), dp)), dp))
    end do
  end subroutine measure_roots

  subroutine measure_shapes(table)
    type(table_type), intent(inout) :: table
    real(qp), allocatable :: gamma(:), k(:), xi(:), value(:)
    type(shape_type) :: shape
    integer :: i
    call table%begin('shapes Φ_k(ξ), k to 10⁶, those γ, ξ and 1 − ξ down to 1e-12', 1.0e-14_dp, 'absolute')
    gamma = column('shapes.txt', 'gamma')
    k = column('shapes.txt', 'k')
    xi = column('shapes.txt', 'xi')
    value = column('shapes.txt', 'shape')
    do i = 1, size(value)
      shape = shape_of(solve_root(nint(k(i)), real(gamma(i), dp)))
      call table%note(real(abs(shape_value(shape, real(xi(i), dp)) - value(i)), dp))
    end do
  end subroutine measure_shapes

  subroutine measure_modal_quantities(table)
    type(table_type), intent(inout) :: table
    type(shape_type), allocatable :: shapes(:)
    shapes = shape_of(solve_root(nint(column('modal_quantities.txt', 'k')), &
                                 real(column('modal_quantities.txt', 'gamma'), dp)))
    call table%begin('Φ_k(1), k to 10⁸', 1.0e-14_dp, 'relative')
    call table%note(relative(shapes%tip, column('modal_quantities.txt', 'tip')))
    call table%begin('Φ''_k(1)', 1.0e-14_dp, 'relative')
    call table%note(relative(shapes%tip_slope, column('modal_quantities.txt', 'tip_slope')))
    call table%begin('modal masses', 1.0e-14_dp, 'relative')
    call table%note(relative(shapes%modal_mass, column('modal_quantities.txt', 'modal_mass')))
    call table%begin('(1 − σ_k)e^α', 1.0e-14_dp, 'relative')
    call table%note(relative(shapes%grow, column('modal_quantities.txt', 'one_minus_sigma_scaled')))
  end subroutine measure_modal_quantities

  elemental real(dp) function relative(found, expected)
    real(dp), intent(in) :: found
    real(qp), intent(in) :: expected
    relative = real(abs(found/expected - 1), dp)
  end function relative

end module shape_numbers
