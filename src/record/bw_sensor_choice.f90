module bw_sensor_choice
  !! The choice of the sensors from which lines are found. A row that lacks a number of one of them is left out, so that one sensor
  !! may cost most rows of the others: those that lack fewest are chosen, so many that the number of sensors times that of their
  !! common rows is largest. A flawed sample costs no other one, but a sensor with very many of them is left out.
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_record, only: record_type
  use bw_record_flaws, only: mark_flaws
  implicit none (type, external)
  private
  public :: choose_sensors

  real(dp), parameter :: most_flawed = 0.25_dp   !! chosen: of its samples; with more a search finds false lines and blows

contains

  pure subroutine choose_sensors(timed, record)
    !! Leave out sensors with so many missing or flawed samples that the others determine the lines better without them.
    logical, intent(in) :: timed(:)               !! rows that have a time
    type(record_type), intent(inout) :: record   !! `flawed` and `left_out` of its sensors are set
    logical :: is_there(size(timed)), chosen(size(record%sensors)), next(size(record%sensors)), is_constant(size(record%sensors))
    integer(i8) :: lacking(size(record%sensors)), flawed(size(record%sensors)), most
    integer :: s, k
    is_constant = [(.not. varies(record%values(:, s), timed), s=1, size(chosen))]
    lacking = [(count(timed .and. is_missing(record%values(:, s)), kind=i8), s=1, size(chosen))]
    flawed = [(flaws_in(pack(record%values(:, s), timed .and. .not. is_missing(record%values(:, s)))), s=1, size(chosen))]
    chosen = .true.
    is_there = timed
    next = .false.
    most = 0
    do k = 1, merge(count(.not. is_constant), 0, any(lacking > 0))
      s = minloc(lacking, dim=1, mask=.not. (next .or. is_constant))
      next(s) = .true.
      is_there = is_there .and. .not. is_missing(record%values(:, s))
      if (k*count(is_there, kind=i8) <= most) cycle
      chosen = next
      most = k*count(is_there, kind=i8)
    end do
    chosen = chosen .or. lacking == 0
    associate (is_sound => flawed < most_flawed*count(timed))
      if (any(chosen .and. is_sound .and. .not. is_constant)) chosen = chosen .and. (is_sound .or. is_constant)
    end associate
    record%sensors%flawed = real(lacking + flawed, dp)/max(1_i8, count(timed, kind=i8))
    record%sensors%left_out = .not. chosen
  end subroutine choose_sensors

  pure integer(i8) function flaws_in(values) result(flawed)
    !! The number of flawed samples.
    real(dp), intent(in) :: values(:)
    logical :: valid(size(values))
    valid = .true.
    if (size(values) > 0) call mark_flaws(values, valid)
    flawed = count(.not. valid, kind=i8)
  end function flaws_in

  pure logical function varies(values, timed)
    !! Return whether not all samples of a sensor are equal or missing.
    real(dp), intent(in) :: values(:)
    logical, intent(in) :: timed(:)
    logical :: is_there(size(values))
    is_there = timed .and. .not. is_missing(values)
    varies = any(is_there)
    if (varies) varies = minval(values, mask=is_there) < maxval(values, mask=is_there)
  end function varies

end module bw_sensor_choice
