module bw_sensor_choice
  !! The choice of the sensors from which lines are found. A row of a record tells of the lines only if its samples are valid at
  !! all of these sensors, so that one bad sensor may cost most rows of good ones. Those with the fewest flawed samples are chosen,
  !! so many that the number of sensors times that of their valid rows is largest.
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_record, only: record_type
  use bw_record_flaws, only: mark_flaws
  implicit none (type, external)
  private
  public :: choose_sensors

contains

  pure subroutine choose_sensors(told, record)
    !! Leave out sensors with so many flawed samples that the others determine the lines better without them.
    logical, intent(in) :: told(:)               !! rows that have a time
    type(record_type), intent(inout) :: record   !! `flawed` and `left_out` of its sensors are set
    logical :: is_valid(size(told)), chosen(size(record%sensors)), next(size(record%sensors)), is_constant(size(record%sensors))
    integer(i8) :: flawed(size(record%sensors)), rows, most
    integer :: s, k, marked
    is_constant = [(.not. varies(record%values(:, s), told), s=1, size(chosen))]
    do marked = 1, 0, -1                         ! flaws that fill most rows are none, but missing samples remain
      flawed = [(count(told .and. .not. valid_samples(record%values(:, s), told, marked == 1), kind=i8), s=1, size(chosen))]
      chosen = .true.
      if (all(flawed == 0)) exit
      is_valid = told
      next = .false.
      rows = 0
      most = 0
      do k = 1, count(.not. is_constant)
        s = minloc(flawed, dim=1, mask=.not. (next .or. is_constant))
        next(s) = .true.
        is_valid = is_valid .and. valid_samples(record%values(:, s), told, marked == 1)
        if (k*count(is_valid, kind=i8) <= most) cycle
        chosen = next
        rows = count(is_valid, kind=i8)
        most = k*rows
      end do
      if (2*rows >= count(told, kind=i8)) exit
    end do
    record%sensors%flawed = real(flawed, dp)/max(1_i8, count(told, kind=i8))
    record%sensors%left_out = .not. chosen .and. flawed > 0
  end subroutine choose_sensors

  pure function valid_samples(values, told, marked) result(is_valid)
    !! Tell which samples of a sensor are neither missing nor, if these are marked, flawed.
    real(dp), intent(in) :: values(:)
    logical, intent(in) :: told(:), marked
    logical :: is_valid(size(values))
    logical, allocatable :: own(:)
    is_valid = told .and. .not. is_missing(values)
    if (.not. (marked .and. any(is_valid))) return
    allocate (own(count(is_valid)), source=.true.)
    call mark_flaws(pack(values, is_valid), own)
    is_valid = unpack(own, is_valid, .false.)
  end function valid_samples

  pure logical function varies(values, told)
    !! Tell whether not all samples of a sensor are equal or missing.
    real(dp), intent(in) :: values(:)
    logical, intent(in) :: told(:)
    logical :: is_there(size(values))
    is_there = told .and. .not. is_missing(values)
    varies = any(is_there)
    if (varies) varies = minval(values, mask=is_there) < maxval(values, mask=is_there)
  end function varies

end module bw_sensor_choice
