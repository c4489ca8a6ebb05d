module bw_pooled_variables
  !! What a result holds of the lines that repeats of a record share: known when all cases are done, and put at the end.
  use bw_error, only: error_type
  use bw_kinds, only: dp, i4
  use bw_missing, only: missing
  use bw_netcdf, only: netcdf_file, variable_text
  use bw_repeats, only: pooled_lines, pooled_words
  use bw_text, only: joined
  use netcdf, only: nf90_inq_varid, nf90_put_var
  implicit none (type, external)
  private
  public :: define_pooled, pooled_variables, put_pooled

  character(*), parameter :: next = 'half the interval that holds what one more repeat measures', &
    scatter = 'standard deviation between repeats beyond their own errors'

contains

  pure function pooled_variables() result(rows)
    !! All of them, in the order in which `put_pooled` has their values: numbers, counts, and to which each line of a case belongs.
    type(variable_text) :: rows(11)
    rows = [ &
      variable_text('pooled_angular_frequency', 'pooled', 'rad s-1', 'angular frequency from all repeats'), &
      variable_text('pooled_angular_frequency_error', 'pooled', 'rad s-1', 'half the interval of that'), &
      variable_text('pooled_angular_frequency_next', 'pooled', 'rad s-1', next), &
      variable_text('pooled_angular_frequency_scatter', 'pooled', 'rad s-1', scatter), &
      variable_text('pooled_decay_rate', 'pooled', 's-1', 'rate of decay from all repeats'), &
      variable_text('pooled_decay_rate_error', 'pooled', 's-1', 'half the interval of that'), &
      variable_text('pooled_decay_rate_next', 'pooled', 's-1', next), &
      variable_text('pooled_decay_rate_scatter', 'pooled', 's-1', scatter), &
      variable_text('pooled_count', 'pooled', '1', 'number of repeats that have the line; 0: there is none', is_integer=.true.), &
      variable_text('pooled_status', 'pooled', '1', 'whether repeats scatter more than their own intervals allow; 0: no line', &
                    is_integer=.true., flags=joined(pooled_words), has_masks=.true.), &
      variable_text('pooled_line', 'case peak', '1', 'the line from all repeats that this one belongs to; 0: none', &
                    is_integer=.true.)]
  end function pooled_variables

  subroutine define_pooled(file, error)
    !! Define all of them. **Errors**: `status_bad_file`.
    class(netcdf_file), intent(in) :: file
    type(error_type), allocatable, intent(inout) :: error
    type(variable_text), allocatable :: rows(:)
    integer :: i, ignored
    rows = pooled_variables()
    do i = 1, size(rows)
      call file%define(rows(i), ignored, error)
    end do
  end subroutine define_pooled

  subroutine put_pooled(file, pooled, error)
    !! Put their values; behind the last line numbers are missing, and counts are 0. **Errors**: `status_bad_file`.
    class(netcdf_file), intent(in) :: file
    type(pooled_lines), intent(in) :: pooled
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: numbers(size(pooled%member, 1), 8)            ! as many lines as a case may have
    integer(i4) :: counts(size(pooled%member, 1), 2)
    type(variable_text), allocatable :: rows(:)
    integer :: variable, i, n
    rows = pooled_variables()
    numbers = missing
    counts = 0
    n = size(pooled%count)
    associate (f => pooled%frequency, d => pooled%decay)
      numbers(:n, :4) = reshape([f%value, f%error, f%next, f%scatter], [n, 4])
      numbers(:n, 5:) = reshape([d%value, d%error, d%next, d%scatter], [n, 4])
    end associate
    counts(:n, 1) = pooled%count
    counts(:n, 2) = pooled%status
    do i = 1, size(numbers, 2)
      call find(file, rows(i), variable, error)
      if (.not. allocated(error)) call file%check(nf90_put_var(file%id, variable, numbers(:, i)), error)
    end do
    do i = 1, size(counts, 2)
      call find(file, rows(size(numbers, 2) + i), variable, error)
      if (.not. allocated(error)) call file%check(nf90_put_var(file%id, variable, counts(:, i)), error)
    end do
    call find(file, rows(size(rows)), variable, error)
    if (.not. allocated(error)) call file%check(nf90_put_var(file%id, variable, int(pooled%member, i4)), error)
  end subroutine put_pooled

  subroutine find(file, row, variable, error)
    !! NetCDF's number of a variable.
    class(netcdf_file), intent(in) :: file
    type(variable_text), intent(in) :: row
    integer, intent(out) :: variable
    type(error_type), allocatable, intent(inout) :: error
    variable = 0
    if (.not. allocated(error)) call file%check(nf90_inq_varid(file%id, trim(row%name), variable), error)
  end subroutine find

end module bw_pooled_variables
