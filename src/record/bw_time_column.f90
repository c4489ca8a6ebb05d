module bw_time_column
  !! Finds the column of a file that holds the times by its name and unit, as loggers write them.
  use bw_record, only: bare_name, column_type
  use bw_sensor_unit, only: factor_of
  implicit none (type, external)
  private
  public :: mark_time, named_time

  character(*), parameter :: plain(*) = [character(4) :: 't', 'time']     !! a column of this name is preferred
  character(*), parameter :: words(*) = [character(13) :: plain, 'times', 'timestamp', 'time stamp', 'elapsed', 'elapsed time', &
    'time elapsed', 'relative time', 'rel time', 'x value', 'xvalue', 'secs', 'seconds', 'zeit', 'zeitpunkt', &
    'messzeit', 'temps', 'tempo', 'tiempo', 'tijd', 'tid']
  character(*), parameter :: counters(*) = [character(6) :: 'millis', 'micros']  !! of microcontrollers, in units of their own
  character(*), parameter :: joints = '/_ '    !! between a name and its unit without brackets, as in `t/s`

contains

  pure subroutine mark_time(column)
    !! Find whether a column holds times. A unit at the end of its name, as in `Zeit/ms` or `time_s`, becomes its unit.
    type(column_type), intent(inout) :: column
    character(:), allocatable :: word
    integer :: joint
    word = spaced(bare_name(column%name))
    column%is_time = any(words == word) .or. any(counters == word)
    if (any(counters == word) .and. column%unit == '') column%unit = merge('ms', 'us', word == counters(1))
    joint = scan(word, joints, back=.true.)
    if (column%is_time .or. joint < 2) return
    if (.not. factor_of(word(joint + 1:), 'time') > 0) return
    column%is_time = any(words == word(:max(1, verify(word(:joint), joints, back=.true.))))
    if (column%is_time .and. column%unit == '') column%unit = word(joint + 1:)
  end subroutine mark_time

  pure function spaced(name) result(word)
    !! Replace underscores of a name by blanks: `x_value` → `x value`.
    character(*), intent(in) :: name
    character(len(name)) :: word
    integer :: i
    do i = 1, len(name)
      word(i:i) = merge(' ', name(i:i), name(i:i) == '_')
    end do
  end function spaced

  pure integer function named_time(columns) result(time)
    !! Return the only column named as a time; of several, the only one with numbers, or of these the only one named time or t.
    !! If none is so named, return the first column if it has numbers in a unit of time; else 0.
    type(column_type), intent(in) :: columns(:)
    logical, dimension(size(columns)) :: named, numeric
    integer :: i
    time = 0
    named = columns%is_time
    numeric = named .and. columns%is_numeric
    if (count(numeric) > 0) named = numeric
    if (count(named) > 1) named = [(named(i) .and. any(plain == bare_name(columns(i)%name)), i=1, size(columns))]
    if (count(named) == 1) time = findloc(named, .true., dim=1)
    if (any(columns%is_time) .or. size(columns) == 0) return
    if (columns(1)%is_numeric .and. factor_of(columns(1)%unit, 'time') > 0) time = 1
  end function named_time

end module bw_time_column
