module bw_record_notes
  !! Notes on a record besides its numbers: units that are not SI, columns and rows that are left out, flawed samples.
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_note, only: remark
  use bw_record, only: clock_text, record_type
  use bw_record_flaws, only: find_flaws, flaws_type
  use bw_record_source, only: record_source
  use bw_sample_times, only: even_interval, first_fall, nearest_even
  use bw_scene, only: scene_type
  use bw_sensor_unit, only: factor_of, force_factor, quantity_of, si_unit
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: add_notes

  integer, parameter :: most_named = 4                 !! sensors named in one note
  integer, parameter :: most_listed = 30               !! columns listed in one note

contains

  subroutine add_notes(scene, source, time, columns, force, record)
    !! Add all notes of a record whose numbers are read.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    integer, intent(in) :: time, columns(:), force     !! columns; 0: there is none
    type(record_type), intent(inout) :: record
    integer :: s
    allocate (record%notes(0))
    do s = 1, size(source%notes)
      call append(record%notes, source%notes(s)%text)
    end do
    if (time > 0) call note_time_unit(source%columns(time)%unit, scene%record%time_scale, record%notes)
    if (force > 0) then
      if (source%columns(force)%unit == '') call append(record%notes, 'force: not given in a unit, and N is assumed')
    end if
    call note_uneven(record)
    if (record%left_out > 0) call append(record%notes, 'rows: '//text_of(record%left_out)//' of '// &
      text_of(record%samples_there)//' are left out: a value or the time is missing, or the time is that of the row before')
    if (2*record%left_out > record%samples_there) call append(record%notes, 'clock: most rows are left out; if it has the '// &
      'same time for many samples, give sample_rate instead of time')
    do s = 1, size(columns)
      call note_unit(scene, source, columns, s, record)
      if (.not. any(is_missing(record%values(:, s)))) call note_flaws(find_flaws(record%values(:, s)), s, record)
      call note_counter(record, s)
    end do
    call note_left_out_sensors(record)
    call note_quantity(scene, source, columns, record)
    call note_left_out(source, time, record%notes)
  end subroutine add_notes

  subroutine note_time_unit(unit, scale, notes)
    !! Note that times were converted to seconds, that their unit is not known, or that the scene gives another scale.
    character(*), intent(in) :: unit
    real(dp), intent(in) :: scale                      !! s over the unit, from the scene; or `missing`
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp) :: factor
    if (unit == '') return
    factor = factor_of(unit, 'time')
    if (is_missing(scale) .and. factor == 0.0_dp) then
      call append(notes, "times: their unit '"//unit//"' is not known, and seconds are assumed; "// &
                  'time_scale gives the unit in seconds')
    else if (is_missing(scale)) then
      if (abs(factor - 1.0_dp) > 0) call remark(notes, "times: converted from '"//unit//"' to s")
    else if (factor > 0.0_dp .and. abs(scale - factor) > 1e-6_dp*factor) then
      call append(notes, "times: their unit '"//unit//"' is "//shortest(factor, 6)//' s, but time_scale is '//shortest(scale, 6))
    end if
  end subroutine note_time_unit

  subroutine note_quantity(scene, source, columns, record)
    !! Note sensors whose quantity and unit neither the scene nor the file gives.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    integer, intent(in) :: columns(:)
    type(record_type), intent(inout) :: record
    character(:), allocatable :: names
    integer :: s, unknown
    if (allocated(scene%record%quantities)) return
    names = ''
    unknown = 0
    do s = 1, size(columns)
      if (source%columns(columns(s))%quantity /= '' .or. record%sensors(s)%unit /= si_unit('displacement')) cycle
      unknown = unknown + 1
      if (unknown <= most_named) names = names//', '//record%sensors(s)%name
    end do
    if (unknown == 0) return
    if (unknown > most_named) names = names//' and '//text_of(unknown - most_named)//' more'
    call append(record%notes, 'quantity: not given in the file for '//names(3:)//'; displacement is assumed, unless '// &
                "quantity = 'acceleration' or another is set")
  end subroutine note_quantity

  subroutine note_uneven(record)
    !! Note times with a small jitter about evenly spaced ones: the clock may be even, and only its time stamps uneven.
    type(record_type), intent(inout) :: record
    real(dp), parameter :: little = 0.05_dp            !! fraction of an interval
    real(dp) :: interval, off
    if (record%interval > 0.0_dp) return
    call nearest_even(record%times, interval, off)
    if (off > little*interval) return
    call append(record%notes, 'times: uneven, by at most '//shortest(100*off/interval, 2)// &
                ' % of the interval; if the recorder samples evenly, use sample_rate = '//shortest(1.0_dp/interval, 12)// &
                ' instead')
  end subroutine note_uneven

  subroutine note_left_out_sensors(record)
    !! Note the sensors without which lines are found.
    type(record_type), intent(inout) :: record
    character(:), allocatable :: names
    integer :: s, named, others
    names = ''
    named = 0
    others = 0
    do s = 1, size(record%sensors)
      if (.not. record%sensors(s)%left_out) cycle
      if (named == most_named) others = others + 1
      if (named == most_named) cycle
      named = named + 1
      names = names//', '//record%sensors(s)%name//' ('//shortest(100*record%sensors(s)%flawed, 2)//' %)'
    end do
    if (named == 0) return
    if (others > 0) names = names//' and '//text_of(others)//' more'
    call append(record%notes, 'sensors: lines are found without those of which many samples are missing, clipped or constant: '// &
      names(3:))
  end subroutine note_left_out_sensors

  subroutine note_counter(record, s)
    !! Note a sensor whose values increase by the same step at each sample: a time or a counter.
    type(record_type), intent(inout) :: record
    integer, intent(in) :: s                           !! the sensor
    real(dp), allocatable :: none(:)
    if (first_fall(record%values(:, s)) > 0) return
    allocate (none(size(record%times)), source=0.0_dp)
    if (.not. even_interval(record%values(:, s), none) > 0.0_dp) return
    call append(record%notes, 'counter: '//record%sensors(s)%name// &
                ' rises by the same step at every sample, like a time or a counter; columns selects the sensors')
  end subroutine note_counter

  subroutine note_unit(scene, source, columns, s, record)
    !! Note that a sensor was converted to SI, that its unit is not known, or that the scene gives another scale. Sensors with
    !! the same unit, quantity and scale share a note.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    integer, intent(in) :: columns(:)
    integer, intent(in) :: s                           !! the sensor
    type(record_type), intent(inout) :: record
    character(:), allocatable :: who, verb, what, si
    real(dp) :: factor
    integer :: n, more
    associate (sensor => record%sensors(s), unit => source%columns(columns(s))%unit, given => allocated(scene%record%scales))
      factor = factor_of(unit, sensor%quantity)
      si = si_unit(sensor%quantity)
      if (unit == '' .or. unit == si) return
      more = 0
      do n = 1, size(columns)
        if (n == s .or. source%columns(columns(n))%unit /= unit .or. record%sensors(n)%quantity /= sensor%quantity .or. &
            abs(record%sensors(n)%scale - sensor%scale) > 0) cycle
        if (n < s) return
        more = more + 1
      end do
      who = 'units: '//sensor%name
      if (more > 0) who = who//' and '//text_of(more)//' more'
      verb = trim(merge(' are', ' is ', more > 0))
      what = who//verb//" in '"//unit//"'"
      if (factor > 0.0_dp .and. .not. given) then
        if (si == '1') si = sensor%quantity
        if (abs(factor - 1.0_dp) > 0) call remark(record%notes, what//', and'//verb//' converted to '//si)
      else if (factor > 0.0_dp) then
        if (abs(sensor%scale/factor - 1.0_dp) > 0.01_dp) call append(record%notes, what//', but scale is '// &
          shortest(sensor%scale, 6)//', not '//shortest(factor, 6))
      else if (force_factor(unit) > 0) then
        call append(record%notes, what//', a unit of force, but'//verb//' treated as '//sensor%quantity// &
          "; force makes a column the hammer's, and columns selects the sensors")
      else if (quantity_of(unit) /= '') then
        call append(record%notes, what//', a unit of '//quantity_of(unit)//', but'//verb//' treated as '//sensor%quantity// &
                    ' in '//sensor%unit)
      else if (sensor%unit /= si) then
        call append(record%notes, what//', which is not a known unit of motion; the values stay in '//sensor%unit// &
                    ' and are treated as '//sensor%quantity//'; quantity and scale convert them to SI')
      end if
    end associate
  end subroutine note_unit

  subroutine note_flaws(flaws, s, record)
    !! Note samples that are constant, stuck, clipped or spikes.
    type(flaws_type), intent(in) :: flaws
    integer, intent(in) :: s                           !! the sensor
    type(record_type), intent(inout) :: record
    associate (name => record%sensors(s)%name)
      if (flaws%is_constant) then
        call append(record%notes, 'constant: '//name//' is '//shortest(flaws%highest, 6)//' in all samples, and '// &
          'contains no lines')
        return
      end if
      if (flaws%clipped_high > 0) call note_clipped(flaws%clipped_high, 'above ', flaws%highest)
      if (flaws%clipped_low > 0) call note_clipped(flaws%clipped_low, 'below ', flaws%lowest)
      if (flaws%stuck_runs > 0) call note_stuck(flaws, s, record)
      if (flaws%spikes > 0) call note_spikes(flaws%spikes, record%values(flaws%spike, s), record%times(flaws%spike))
    end associate

  contains

    subroutine note_spikes(samples, value, time)
      integer(i8), intent(in) :: samples
      real(dp), intent(in) :: value, time              ! of the largest
      call append(record%notes, 'spike: '//record%sensors(s)%name//' is '//shortest(value, 6)//' at '// &
        clock_text(record%origin + time, record%times(size(record%times)))//' s, far from all other samples; left out: '// &
        text_of(samples)//trim(merge(' sample ', ' samples', samples == 1)))
    end subroutine note_spikes

    subroutine note_clipped(samples, side, value)
      integer(i8), intent(in) :: samples
      character(*), intent(in) :: side
      real(dp), intent(in) :: value
      call append(record%notes, 'clipped: '//record%sensors(s)%name//' is cut off '//side//shortest(value, 6)//' in '// &
                  text_of(samples)//' samples')
    end subroutine note_clipped

  end subroutine note_flaws

  subroutine note_stuck(flaws, s, record)
    !! Note a value that is constant for a time.
    type(flaws_type), intent(in) :: flaws
    integer, intent(in) :: s                           !! the sensor
    type(record_type), intent(inout) :: record
    character(:), allocatable :: text
    real(dp) :: used                                   ! s
    used = record%times(size(record%times))
    text = 'constant: '//record%sensors(s)%name//' stays at '//shortest(record%values(flaws%stuck_first, s), 6)//' from '// &
      clock_text(record%origin + record%times(flaws%stuck_first), used)//' to '// &
      clock_text(record%origin + record%times(flaws%stuck_last), used)//' s'
    if (flaws%stuck_runs > 1) text = text//', and '//text_of(flaws%stuck_runs - 1)//' more times'
    call append(record%notes, text)
  end subroutine note_stuck

  subroutine note_left_out(source, time, notes)
    !! Note columns without numbers, or without a quantity in a file that gives those of others.
    class(record_source), intent(in) :: source
    integer, intent(in) :: time
    type(string), allocatable, intent(inout) :: notes(:)
    character(:), allocatable :: text
    integer :: i, others
    text = ''
    others = 0
    do i = 1, size(source%columns)
      if (source%columns(i)%is_numeric .or. source%columns(i)%is_time .or. i == time) cycle
      others = others + 1
      if (others <= most_listed) text = text//', '//text_of(i)
    end do
    if (others > most_listed) text = text//' and '//text_of(others - most_listed)//' more'
    if (text /= '') call remark(notes, 'columns: left out, since they hold no numbers: '//text(3:))
  end subroutine note_left_out

end module bw_record_notes
