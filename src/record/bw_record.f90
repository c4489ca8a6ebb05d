module bw_record
  !! A record: histories of sensors along a beam, read from a file and ready for analysis, and the description of the file's
  !! columns.
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_sensor_unit, only: si_unit
  use bw_text, only: lower, shortest, string, text_of
  implicit none (type, external)
  private
  public :: bare_name, clock_text, extent_of, is_even, measure_the_same, quantities_of, unit_in, without_unit

  type, public :: column_type
    !! A column of a table, or a variable of a file.
    character(:), allocatable :: name            !! as in the file; '' if it has none
    character(:), allocatable :: unit            !! as in the file; '' if not given
    character(:), allocatable :: quantity        !! 'displacement', 'velocity', 'acceleration', 'strain'; '' if not given
    real(dp) :: position = missing               !! ξ; `missing` if not given
    logical :: is_numeric = .true.               !! it holds numbers
    logical :: is_time = .false.                 !! its name says that it holds the times
  end type column_type

  type, public :: sensor_type
    character(:), allocatable :: name            !! of its column, or its number
    character(:), allocatable :: quantity        !! one of those above
    character(:), allocatable :: unit            !! of its numbers: SI, or the file's if that is not known
    real(dp) :: scale = 1.0_dp                   !! that unit over the file's
    real(dp) :: position = missing               !! ξ in [0, 1]; `missing` if not given
    real(dp) :: flawed = 0.0_dp                  !! share of its samples that are missing or flawed, if any sensor has such
    logical :: left_out = .false.                !! lines are found without it, since it has too many
  end type sensor_type

  type, public :: record_type
    character(:), allocatable :: path            !! of the file
    integer(i8) :: samples_there = 0             !! in the file, before a part is selected
    integer(i8) :: left_out = 0                  !! in the part used, for lack of a number or of a time of their own
    real(dp) :: origin = 0.0_dp                  !! time of the first sample used, in the file [s]
    real(dp) :: interval = 0.0_dp                !! of evenly spaced samples [s], > 0; 0 if uneven
    real(dp) :: resolution = 0.0_dp              !! last digit of the late times [s]; 0: all digits are known
    real(dp), allocatable :: times(:)            !! since the first sample [s], increasing; evenly spaced: (j−1)·interval, (samples)
    real(dp), allocatable :: values(:, :)        !! in the sensors' units; `missing` at sensors left out only, (samples, sensors)
    real(dp), allocatable :: force(:)            !! of the hammer [N], also in rows left out; unallocated: not known
    real(dp), allocatable :: force_times(:)      !! since the first sample [s]
    type(sensor_type), allocatable :: sensors(:) !! (sensors)
    type(string), allocatable :: notes(:)        !! notes on the record, one line each
  end type record_type

  type, public :: record_extent
    !! The description of a record without its samples.
    character(:), allocatable :: path            !! of the file
    integer(i8) :: samples_there = 0             !! in the file
    integer :: samples = 0                       !! number of samples used
    integer :: absent = 0                        !! samples missing between them on an even grid
    real(dp) :: origin = 0.0_dp                  !! time of the first sample used, in the file [s]
    real(dp) :: duration = 0.0_dp                !! from the first sample to the last [s]
    real(dp) :: steps(2) = 0.0_dp                !! smallest and largest interval [s]; equal if evenly spaced
    type(sensor_type), allocatable :: sensors(:) !! (sensors)
    real(dp), allocatable :: ranges(:, :)        !! least and largest sample of each, in its unit; `missing`: none, (2, sensors)
    type(string), allocatable :: notes(:)        !! as in the record
  end type record_extent

contains

  pure type(record_extent) function extent_of(record) result(extent)
    !! Return the description of a record without its samples.
    type(record_type), intent(in) :: record
    integer :: n, s
    n = size(record%times)
    extent%path = record%path
    extent%samples_there = record%samples_there
    extent%samples = n
    extent%origin = record%origin
    extent%duration = record%times(n)
    extent%steps = record%interval
    if (.not. record%interval > 0.0_dp) then
      extent%steps = [minval(record%times(2:) - record%times(:n - 1)), maxval(record%times(2:) - record%times(:n - 1))]
    end if
    extent%sensors = record%sensors
    allocate (extent%ranges(2, size(record%sensors)))
    do s = 1, size(record%sensors)
      associate (values => record%values(:, s))
        extent%ranges(:, s) = [minval(values, mask=.not. is_missing(values)), maxval(values, mask=.not. is_missing(values))]
        if (all(is_missing(values))) extent%ranges(:, s) = missing
      end associate
    end do
    extent%notes = record%notes
  end function extent_of

  pure function clock_text(time, span) result(text)
    !! Write a time with six digits, or as many as resolve a thousandth of a span: a clock may count from long ago.
    real(dp), intent(in) :: time                 !! s
    real(dp), intent(in) :: span                 !! s, > 0
    character(:), allocatable :: text
    real(dp), parameter :: most_plain = 1.0e7_dp
    integer, parameter :: fewest = 6, most = 15
    character(40) :: buffer
    integer :: digits, decimals
    digits = fewest
    if (abs(time) > span) digits = min(most, max(fewest, ceiling(log10(abs(time)/span)) + 4))
    text = shortest(time, digits)
    if (abs(time) < most_plain) return
    decimals = max(1, digits - 1 - floor(log10(abs(time))))
    write (buffer, '(f40.'//text_of(decimals)//')') time
    text = trim(adjustl(buffer))
    do while (text(len(text):) == '0')
      text = text(:len(text) - 1)
    end do
    if (text(len(text):) == '.') text = text(:len(text) - 1)
  end function clock_text

  pure logical function is_even(extent)
    !! Return whether the samples are evenly spaced.
    type(record_extent), intent(in) :: extent
    is_even = extent%steps(1) >= extent%steps(2)
  end function is_even

  pure logical function measure_the_same(sensors, others)
    !! Return whether two records have sensors of the same quantities in the same units, whatever their names.
    type(sensor_type), intent(in) :: sensors(:), others(:)
    measure_the_same = quantities_of(sensors) == quantities_of(others) .and. size(sensors) == size(others)
  end function measure_the_same

  pure function quantities_of(sensors) result(text)
    !! List what sensors measure, in their order: `2 x displacement, strain`; with the unit if it is not SI: `displacement in V`.
    type(sensor_type), intent(in) :: sensors(:)
    character(:), allocatable :: text, what
    integer :: first, last
    text = ''
    last = 0
    do while (last < size(sensors))
      first = last + 1
      what = quantity_text(sensors(first))
      do last = first, size(sensors) - 1
        if (quantity_text(sensors(last + 1)) /= what) exit
      end do
      if (first > 1) text = text//', '
      if (last > first) text = text//text_of(last - first + 1)//' x '
      text = text//what
    end do
  end function quantities_of

  pure function quantity_text(sensor) result(text)
    !! Return the quantity of a sensor, with its unit if that is not SI.
    type(sensor_type), intent(in) :: sensor
    character(:), allocatable :: text
    text = sensor%quantity
    if (sensor%unit /= si_unit(sensor%quantity)) text = text//' in '//sensor%unit
  end function quantity_text

  pure function bare_name(name) result(bare)
    !! Return a name in lower case, without its unit in brackets: `Time [s]` → `time`.
    character(*), intent(in) :: name
    character(:), allocatable :: bare
    bare = without_unit(lower(name))
  end function bare_name

  pure function unit_in(name) result(unit)
    !! Return the unit in brackets after a name: `Time [s]` → `s`; empty if there is none.
    character(*), intent(in) :: name
    character(:), allocatable :: unit
    character(:), allocatable :: text
    integer :: open
    unit = ''
    text = trim(adjustl(name))
    open = opening(text)
    if (open > 0) unit = trim(adjustl(text(open + 1:len(text) - 1)))
  end function unit_in

  pure function without_unit(name) result(short)
    !! Return a name without its unit in brackets: `Time [s]` → `Time`; unchanged if nothing would remain.
    character(*), intent(in) :: name
    character(:), allocatable :: short
    integer :: open
    short = trim(adjustl(name))
    open = opening(short)
    if (open > 1) short = trim(short(:open - 1))
  end function without_unit

  pure integer function opening(text) result(open)
    !! Return the place of the bracket that opens the last part of a text; 0 if the text does not end in a bracket.
    character(*), intent(in) :: text
    open = 0
    if (len(text) == 0) return
    if (text(len(text):) == ']') open = index(text, '[', back=.true.)
    if (text(len(text):) == ')') open = index(text, '(', back=.true.)
  end function opening

end module bw_record
