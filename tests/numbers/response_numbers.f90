module response_numbers
  !! Histories around the critical angular velocity, over long times, and to the end of the range of numbers.
  use bw_kinds, only: dp, qp
  use bw_missing, only: is_missing
  use bw_response, only: response_type
  use number_table, only: table_type
  use paper_motion, only: catch_mass, catch_type, paper_beam
  use reference_table, only: column
  implicit none (type, external)
  private
  public :: measure_critical, measure_long_times, measure_overflow

  real(dp), parameter :: points(3) = [0.1_dp, 0.5_dp, 1.0_dp]

  type :: history_table
    !! A table of histories: rows for the same motion stand together.
    integer, allocatable :: first(:)                !! row of each motion
    real(dp), allocatable :: omega(:), duration(:)  !! (motions)
    integer, allocatable :: samples(:)              !! (motions)
    integer, allocatable :: j(:), point(:)          !! sample, from 0, and point, (rows)
    real(qp), allocatable :: displacement(:), velocity(:)   !! (rows)
  end type history_table

contains

  subroutine measure_critical(table)
    type(table_type), intent(inout) :: table
    type(history_table) :: histories
    real(dp), allocatable :: error(:), error_rate(:)
    integer :: stride
    histories = history_table_of('critical_responses.txt')
    call all_errors(histories, 5, error, error_rate)
    call table%begin('displacement at ω = ω_c(1 ± 10⁻ᵏ), k = 3 … 15, and at ω_c, to 1 s', 1.0e-12_dp, 'part of the peak')
    call table%note(abs(error))
    call table%begin('velocity at those ω', 1.0e-12_dp, 'part of the peak')
    call table%note(abs(error_rate))
    call table%begin('step from each of these ω to the next', 1.0e-12_dp, 'part of the peak')
    stride = size(error)/size(histories%first)
    call table%note(abs(error(1 + stride:) - error(:size(error) - stride)))
  end subroutine measure_critical

  subroutine measure_long_times(table)
    type(table_type), intent(inout) :: table
    real(dp), allocatable :: error(:), error_rate(:)
    call all_errors(history_table_of('long_responses.txt'), 46, error, error_rate)
    call table%begin('displacement to t = 1, 10³, 10⁶, 10⁹ s, βt to 10¹⁵', 1.0e-12_dp, 'part of the peak')
    call table%note(abs(error))
    call table%begin('velocity at those times', 1.0e-12_dp, 'part of the peak')
    call table%note(abs(error_rate))
  end subroutine measure_long_times

  subroutine measure_overflow(table)
    type(table_type), intent(inout) :: table
    type(history_table) :: histories
    type(response_type) :: response
    real(dp), allocatable :: error(:), error_rate(:), missed(:)
    integer, allocatable :: last(:)
    integer :: i
    histories = history_table_of('overflows.txt')
    allocate (error(0), error_rate(0), missed(0))
    last = nint(column('overflows.txt', 'last'))
    do i = 1, size(histories%first)
      call follow(histories, i, 5, with_velocity=.false., response=response)
      missed = [missed, real(abs(last(histories%first(i)) + 1 - response%finite_samples) &
                             + count(is_missing(response%displacement(:response%finite_samples, :))) &
                             + count(.not. is_missing(response%displacement(response%finite_samples + 1:, :))), dp)]
      error = [error, relative(histories, i, histories%displacement, response%displacement, response%finite_samples)]
      call follow(histories, i, 5, with_velocity=.true., response=response)
      error_rate = [error_rate, relative(histories, i, histories%velocity, response%velocity, response%finite_samples)]
    end do
    call table%begin('displacement beyond ω_c until it overflows', 1.0e-12_dp, 'relative')
    call table%note(error)
    call table%begin('velocity beyond ω_c until it overflows', 1.0e-12_dp, 'relative')
    call table%note(error_rate)
    call table%begin('the last finite sample beyond ω_c, then fill', 0.0_dp, 'samples wrongly filled or not')
    call table%note(missed)
  end subroutine measure_overflow

  subroutine all_errors(histories, modes, displacement, velocity)
    !! Signed errors over the peaks of the same histories, (rows).
    type(history_table), intent(in) :: histories
    integer, intent(in) :: modes
    real(dp), allocatable, intent(out) :: displacement(:), velocity(:)
    type(response_type) :: response
    integer :: i
    allocate (displacement(0), velocity(0))
    do i = 1, size(histories%first)
      call follow(histories, i, modes, with_velocity=.true., response=response)
      displacement = [displacement, of_peak(histories, i, histories%displacement, response%displacement)]
      velocity = [velocity, of_peak(histories, i, histories%velocity, response%velocity)]
    end do
  end subroutine all_errors

  subroutine follow(histories, i, modes, with_velocity, response)
    !! The i-th motion of a table.
    type(history_table), intent(in) :: histories
    integer, intent(in) :: i, modes
    logical, intent(in) :: with_velocity
    type(response_type), intent(out) :: response
    call catch_mass(paper_beam(), catch_type(omega=histories%omega(i), modes=modes, duration=histories%duration(i), &
                                             samples=histories%samples(i)), points, with_velocity, response)
  end subroutine follow

  pure function of_peak(histories, i, expected, found) result(errors)
    type(history_table), intent(in) :: histories
    integer, intent(in) :: i
    real(qp), intent(in) :: expected(:)
    real(dp), intent(in) :: found(:, :)
    real(dp) :: errors(rows_of(histories, i))
    integer :: n, row
    do n = 1, size(errors)
      row = histories%first(i) + n - 1
      associate (p => histories%point(row))
        errors(n) = real((found(histories%j(row) + 1, p) - expected(row))/maxval(abs(found(:, p))), dp)
      end associate
    end do
  end function of_peak

  pure function relative(histories, i, expected, found, finite) result(errors)
    !! Of the rows that are among the finite samples.
    type(history_table), intent(in) :: histories
    integer, intent(in) :: i, finite
    real(qp), intent(in) :: expected(:)
    real(dp), intent(in) :: found(:, :)
    real(dp), allocatable :: errors(:)
    integer :: n, row
    allocate (errors(0))
    do n = 1, rows_of(histories, i)
      row = histories%first(i) + n - 1
      if (histories%j(row) >= finite) cycle
      errors = [errors, real(abs(found(histories%j(row) + 1, histories%point(row))/expected(row) - 1), dp)]
    end do
  end function relative

  pure integer function rows_of(histories, i) result(rows)
    type(history_table), intent(in) :: histories
    integer, intent(in) :: i
    rows = size(histories%j) + 1 - histories%first(i)
    if (i < size(histories%first)) rows = histories%first(i + 1) - histories%first(i)
  end function rows_of

  type(history_table) function history_table_of(file) result(histories)
    character(*), intent(in) :: file
    real(qp), allocatable :: omega(:), duration(:), xi(:)
    integer :: row
    omega = column(file, 'omega')
    duration = column(file, 'duration')
    histories%first = pack([(row, row=1, size(omega))], &
                           [.true., omega(2:) /= omega(:size(omega) - 1) .or. duration(2:) /= duration(:size(omega) - 1)])
    histories%omega = real(omega(histories%first), dp)
    histories%duration = real(duration(histories%first), dp)
    histories%samples = nint(column(file, 'samples'))
    histories%samples = histories%samples(histories%first)
    histories%j = nint(column(file, 'j'))
    xi = column(file, 'xi')
    histories%point = [(minloc(abs(points - real(xi(row), dp)), 1), row=1, size(xi))]
    histories%displacement = column(file, 'displacement')
    histories%velocity = column(file, 'velocity')
  end function history_table_of

end module response_numbers
