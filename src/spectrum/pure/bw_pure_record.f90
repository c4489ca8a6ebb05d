module bw_pure_record
  !! Records of lines and rounding without noise: histories of simulations. If it is not known whether a record is one, a part of
  !! it is tested first, and then whether its lines, found to the last digit, leave no more than rounding.
  !!
  !! The search in noise (bw_line_search) cannot replace this one. It finds lines that are two or more bins apart as exactly, in ten
  !! to fifty times the time; of 2 to 8 lines that are 0.2 to 3 bins apart it finds another number in a third of the records, since
  !! it adds and splits lines only where noise would not have caused them.
  use bw_kinds, only: dp
  use bw_lapack, only: dgelsy
  use bw_line, only: line_type
  use bw_line_group, only: group_type, refit_group
  use bw_monitor, only: monitor_type, stops
  use bw_samples, only: samples_type
  use bw_tapered_residual, only: chance, find_residual, residual_type, rounding_of, strength
  use bw_tapered_search, only: find_pure_lines
  implicit none (type, external)
  private
  public :: find_lines_if_pure

  real(dp), parameter, public :: safety = 10
    !! standard deviations of the residual in the bound of a pure record's line, since rounding is not random. Tuned on random
    !! records, some with noise: 5 is enough without noise, not always with it
  real(dp), parameter, public :: rounding = 32*epsilon(1.0_dp)
    !! relative, of a frequency; frequencies of modes, and so of their sum, have been up to 7 epsilon wrong
  integer, parameter :: fewest = 16, stretch = 500  !! samples; `stretch` of them are tested first and may hold 120 lines
  integer, parameter :: whole = 256              !! samples of the longest record whose lines are found in all bins at once
  integer, parameter :: most_numbers = 2**24     !! of all sensors together; more would need too much memory
  real(dp), parameter :: quietest = 1.0e-9_dp    !! relative to the record; no measurement has so little noise
  real(dp), parameter :: unexplained = 1.0e-11_dp  !! relative to the record: residual in a bin of a pure one

contains

  subroutine find_lines_if_pure(samples, lines, residual, pure, monitor)
    !! Find the lines of an evenly sampled record without noise; an offset is a line of frequency 0.
    type(samples_type), intent(in) :: samples
    type(line_type), allocatable, intent(out) :: lines(:)
    type(residual_type), intent(out) :: residual !! of these lines
    logical, intent(out) :: pure                 !! false: there is noise, and the lines are invalid
    class(monitor_type), intent(inout), optional :: monitor
    allocate (lines(0))
    pure = samples%pure
    if (.not. pure) then
      if (.not. looks_pure(samples)) return
    end if
    associate (record => samples%value(:samples%count, :))
      call find_pure_lines(record, lines, residual, monitor)
      if (stops(monitor)) return
      if (size(record, 1) <= whole .and. .not. explained(record, lines, residual)) then
        if (looks_pure(samples)) call take_whole(record, lines, residual)
      end if
      pure = pure .or. explained(record, lines, residual)
    end associate
  end subroutine find_lines_if_pure

  pure logical function explained(record, lines, residual)
    !! Whether the residual is no more than rounding.
    real(dp), intent(in) :: record(:, :)
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(in) :: residual
    integer :: s
    explained = maxval(strength(residual)) <= max(chance*rounding_of(lines, residual%count), &
      & unexplained*norm2([(norm2(record(:, s)), s=1, size(record, 2))]))
  end function explained

  subroutine take_whole(record, lines, residual)
    !! Find all lines of a short record at once, since no bins between them separate groups; they are kept if they explain the
    !! record.
    real(dp), intent(in) :: record(:, :)
    type(line_type), allocatable, intent(inout) :: lines(:)
    type(residual_type), intent(inout) :: residual
    type(residual_type) :: fresh
    type(group_type) :: group
    call find_residual(record, [line_type ::], fresh)
    allocate (group%lines(0))
    group%peaks = [0, size(record, 1)/2]
    call refit_group(fresh, group)
    call find_residual(record, group%lines, fresh)
    if (.not. explained(record, group%lines, fresh)) return
    call move_alloc(group%lines, lines)
    residual = fresh
  end subroutine take_whole

  logical function looks_pure(samples)
    !! Whether the sensor with the largest sample obeys a linear recursion around it.
    type(samples_type), intent(in) :: samples
    integer :: n, first, largest(2)
    looks_pure = .false.
    if (allocated(samples%place) .or. samples%count < fewest) return
    if (samples%count > most_numbers/size(samples%value, 2)) return
    n = min(samples%count, stretch)
    largest = maxloc(abs(samples%value(:samples%count, :)))
    first = min(largest(1), samples%count - n + 1)
    associate (part => samples%value(first:first + n - 1, largest(2)))
      if (maxval(abs(part)) > 0) looks_pure = has_recursion(part/maxval(abs(part)))
    end associate
  end function looks_pure

  logical function has_recursion(record)
    !! Whether each sample follows from those before it: K real exponentials, or half as many lines, obey a linear recursion of
    !! order K, so that a matrix of shifted records has rank K.
    real(dp), intent(in) :: record(:)            !! at most 1 in absolute value
    real(dp), allocatable :: matrix(:, :), right(:, :), work(:)
    integer, allocatable :: pivot(:)
    integer :: order, rows, rank, info, i
    order = (size(record) - 1)/2
    rows = size(record) - order
    allocate (matrix(rows, order), work(64*(rows + order)), pivot(order))
    do i = 1, order
      matrix(:, i) = record(i:i + rows - 1)
    end do
    right = reshape(record(order + 1:), [rows, 1])
    pivot = 0
    call dgelsy(rows, order, 1, matrix, rows, right, rows, pivot, quietest, rank, work, size(work), info)
    has_recursion = rank < order
  end function has_recursion

end module bw_pure_record
