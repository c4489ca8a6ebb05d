module bw_record_summary
  !! The description of a record by `beamwave check`: its samples and sensors.
  use bw_columns, only: short
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_record, only: clock_text, is_even, record_extent, sensor_type
  use bw_sensor_unit, only: si_unit
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: record_summary

  integer, parameter :: most_sensors = 16            !! listed one by one
  integer, parameter :: digits = 6
  real(dp), parameter :: long_ago = 1.0e3_dp !! in durations; with six digits, later start and end times cannot be distinguished

contains

  function record_summary(record) result(text)
    !! Return the description line by line, indented by two.
    type(record_extent), intent(in) :: record
    character(:), allocatable :: text
    type(text_builder) :: lines
    integer :: s
    call lines%append_line('  record     '//record%path//': '//samples_text(record))
    call lines%append_line('  times      '//times_text(record))
    call lines%append_line('  spectrum   0 to '//shortest(0.5_dp*(record%samples + record%absent - 1)/record%duration, digits)// &
                           ' Hz, resolution 1/duration = '//shortest(1.0_dp/record%duration, 3)//' Hz')
    do s = 1, min(size(record%sensors), most_sensors)
      call lines%append_line('  sensor     '//sensor_text(record%sensors(s))//': '// &
                             short(record%ranges(1, s), digits)//' to '// &
                             short(record%ranges(2, s), digits)//' '//record%sensors(s)%unit)
    end do
    if (size(record%sensors) > most_sensors) call lines%append_line('  sensor     ... and '// &
      text_of(size(record%sensors) - most_sensors)//' more')
    text = lines%text()
  end function record_summary

  pure function samples_text(record) result(text)
    !! Report the number of samples used, of all, and of sensors.
    type(record_extent), intent(in) :: record
    character(:), allocatable :: text
    text = text_of(record%samples)//' samples'
    if (record%samples < record%samples_there) text = text//' of '//text_of(record%samples_there)
    text = text//', '//text_of(size(record%sensors))//' sensor'
    if (size(record%sensors) > 1) text = text//'s'
  end function samples_text

  pure function times_text(record) result(text)
    !! Report time span and sampling rate; for times counted from a distant origin, start and duration.
    type(record_extent), intent(in) :: record
    character(:), allocatable :: text
    if (abs(record%origin) > long_ago*record%duration) then
      text = 'from '//clock_text(record%origin, record%duration)//' s on, for '//shortest(record%duration, digits)//' s, '
    else
      text = shortest(record%origin, digits)//' to '//shortest(record%origin + record%duration, digits)//' s, '
    end if
    if (is_even(record)) then
      text = text//'even, '//shortest(1.0_dp/record%steps(1), digits)//' Hz'
      if (record%absent > 0) text = text//', without '//text_of(record%absent)//' samples in between'
    else
      text = text//'uneven, '//shortest((record%samples - 1)/record%duration, digits)//' Hz on average, intervals of '// &
        shortest(record%steps(1), digits)//' to '//shortest(record%steps(2), digits)//' s'
    end if
  end function times_text

  pure function sensor_text(sensor) result(text)
    !! Return a sensor's name, quantity, and position.
    type(sensor_type), intent(in) :: sensor
    character(:), allocatable :: text
    text = sensor%name
    if (sensor%unit /= si_unit(sensor%quantity)) then
      text = text//', treated as '//sensor%quantity
    else if (sensor%name /= sensor%quantity) then
      text = text//', '//sensor%quantity
    end if
    if (.not. is_missing(sensor%position)) text = text//' at xi = '//shortest(sensor%position, digits)
  end function sensor_text

end module bw_record_summary
