program numbers
  !! Measures the hard cases against their references, prints the table, and fails where a bound is missed.
  !! `numbers FILE` writes the table to a file as well.
  use, intrinsic :: iso_fortran_env, only: output_unit
  use capture_numbers, only: measure_capture, measure_integrals
  use dispersion_numbers, only: measure_dispersion
  use galerkin_numbers, only: measure_galerkin
  use limit_numbers, only: measure_limits
  use number_table, only: table_type
  use orthogonality_numbers, only: measure_orthogonality
  use precision_numbers, only: measure_extended_precision
  use response_numbers, only: measure_critical, measure_long_times, measure_overflow
  use shape_numbers, only: measure_modal_quantities, measure_roots, measure_shapes
  use spectrum_numbers, only: measure_spectrum
  use unit_numbers, only: measure_units
  use zero_numbers, only: measure_zeros
  implicit none (type, external)
  type(table_type) :: table
  character(4096) :: path
  integer :: length

  call measure_roots(table)
  call measure_shapes(table)
  call measure_modal_quantities(table)
  call measure_integrals(table)
  call measure_capture(table)
  call measure_orthogonality(table)
  call measure_critical(table)
  call measure_overflow(table)
  call measure_long_times(table)
  call measure_dispersion(table)
  call measure_units(table)
  call measure_limits(table)
  call measure_galerkin(table)
  call measure_spectrum(table)
  call measure_zeros(table)
  call measure_extended_precision(table)

  call table%write_markdown(output_unit)
  call get_command_argument(1, path, length)
  if (length > 0) call table%write_to_file(path(:length))
  if (.not. table%all_kept()) stop 1, quiet=.true.
end program numbers
