module bw_record_plan
  !! What the files of a record hold, as far as the axes of its result depend on it. All files are read before any is analysed,
  !! so that a bad one is refused before there is any work to lose.
  use bw_error, only: error_type, fail, status_bad_input
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_order, only: quantile_of
  use bw_read_record, only: least_samples, read_record, record_path
  use bw_record, only: clock_text, extent_of, measure_the_same, quantities_of, record_extent, record_type
  use bw_record_checksum, only: record_checksums
  use bw_record_view, only: step_of
  use bw_result_layout, only: record_layout, result_layout
  use bw_sample_times, only: used_part
  use bw_scene, only: scene_type
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: plan_record

  integer, parameter :: most_shown = 200000
    !! numbers of a picture's array that a result holds, all cases together: 1.6 MB
  integer, parameter :: fewest_shown = 64         !! of a sensor in one case; fewer make no picture, and are left out
  integer, parameter :: most_even = 64            !! even samples for each that there is  ! tuned
  real(dp), parameter :: same = 1.0e-12_dp        !! of an interval

contains

  subroutine plan_record(scene, layout, extents, record, error)
    !! Read all files of a record, and complete the layout of its result.
    !! **Errors**: those of `read_record`; `status_bad_input` where repeats have other sensors, or a case too few samples.
    type(scene_type), intent(in) :: scene         !! with a record
    type(result_layout), intent(inout) :: layout
    type(record_extent), allocatable, intent(out) :: extents(:)   !! (files); of sweeps of the longest part that is used
    type(record_type), intent(out) :: record      !! the last file's
    type(error_type), allocatable, intent(out) :: error
    type(scene_type) :: widest
    real(dp) :: steps(size(scene%record%files))   ! s
    integer :: f
    widest = scene
    widest%record%first_time = minval(values_of(scene, 'record%start', scene%record%first_time))
    widest%record%last_time = maxval(values_of(scene, 'record%end', scene%record%last_time))
    allocate (extents(size(scene%record%files)))
    allocate (layout%record)
    call record_checksums(scene, layout%record%checksums, error)
    do f = 1, size(extents)
      if (.not. allocated(error)) call read_record(widest, f, record, error)
      if (allocated(error)) return
      extents(f) = extent_of(record)
      steps(f) = step_of(record)
      call check_gaps(record, 1, size(record%times), error)
      if (.not. allocated(error)) call check_parts(scene, record, error)
      if (.not. allocated(error)) call check_sensors(scene, extents(f), extents(1), error)
    end do
    if (.not. allocated(error)) layout%record%longest = &
      maxval(max(extents%samples, int(min(extents%duration/steps + 1, real(huge(1), dp)))))
    if (.not. allocated(error)) call set_axes(extents, record%times, &
      size(values_of(scene, 'record%start', 0.0_dp)) > 1, layout)
    if (.not. allocated(error) .and. layout%samples > 0) call set_frequencies(extents, steps, layout)
  end subroutine plan_record

  pure function values_of(scene, parameter, value) result(values)
    !! The values that an input takes.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: parameter
    real(dp), intent(in) :: value                 !! where it is not swept
    real(dp), allocatable :: values(:)
    integer :: i
    values = [value]
    do i = 1, size(scene%sweeps)
      if (scene%sweeps(i)%parameter == parameter) values = scene%sweeps(i)%values
    end do
  end function values_of

  subroutine check_parts(scene, record, error)
    !! Every part of a record that a case uses has samples enough. **Errors**: `status_bad_input`.
    type(scene_type), intent(in) :: scene
    type(record_type), intent(in) :: record       !! of the longest part
    type(error_type), allocatable, intent(inout) :: error
    real(dp), allocatable :: starts(:), ends(:)
    integer(i8) :: first, last
    integer :: i, j
    starts = values_of(scene, 'record%start', scene%record%first_time)
    ends = values_of(scene, 'record%end', scene%record%last_time)
    if (size(starts) == 1 .and. size(ends) == 1) return      ! that part is the record
    do i = 1, size(starts)
      do j = 1, size(ends)
        call used_part(record%times, starts(i) - record%origin, ends(j) - record%origin, first, last)
        call check_gaps(record, int(first), int(last), error)
        if (allocated(error)) return
        if (last - first + 1 >= least_samples) cycle
        call fail(error, status_bad_input, scene%file//': &sweep: of '//record%path//' '//text_of(max(0_i8, last - first + 1))// &
                  ' samples are left '//part_text(starts(i), ends(j))//'; accepted: '//text_of(least_samples)//' or more')
        return
      end do
    end do
  end subroutine check_parts

  subroutine check_gaps(record, first, last, error)
    !! Uneven samples fill enough of their time: the search for lines takes as much memory as even ones over all of it.
    !! **Errors**: `status_bad_input`, with the longest gap.
    type(record_type), intent(in) :: record
    integer, intent(in) :: first, last            !! of the samples
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: steps(max(0, last - first)), even ! s; how many even samples fill the time
    integer :: at
    if (record%interval > 0 .or. last - first < least_samples) return
    steps = record%times(first + 1:last) - record%times(first:last - 1)
    even = sum(steps)/quantile_of(steps, 0.5_dp)
    if (even <= most_even*size(steps)) return
    at = first + maxloc(steps, dim=1)
    call fail(error, status_bad_input, record%path//': has no samples between '//time_text(at - 1)//' and '//time_text(at)// &
              ' s, and '//text_of(last - first + 1)//' in all where '//shortest(even, 3)//' at their usual interval would fill '// &
              'the time; accepted: up to '//text_of(most_even)//' times fewer; start or end leaves out what is beyond a gap')
  contains
    function time_text(sample) result(text)
      integer, intent(in) :: sample
      character(:), allocatable :: text
      text = clock_text(record%origin + record%times(sample), record%times(last) - record%times(first))
    end function time_text
  end subroutine check_gaps

  pure function part_text(start, end) result(text)
    !! A part of a record in words.
    real(dp), intent(in) :: start, end            !! s
    character(:), allocatable :: text
    text = ''
    if (start > -huge(start)) text = 'from start = '//shortest(start, 6)
    if (start > -huge(start) .and. end < huge(end)) text = text//' '
    if (end < huge(end)) text = text//'up to end = '//shortest(end, 6)
  end function part_text

  subroutine check_sensors(scene, extent, first, error)
    !! Repeats have the same sensors. **Errors**: `status_bad_input`.
    type(scene_type), intent(in) :: scene
    type(record_extent), intent(in) :: extent, first
    type(error_type), allocatable, intent(inout) :: error
    if (measure_the_same(extent%sensors, first%sensors)) return
    call fail(error, status_bad_input, extent%path//': its sensors ('//quantities_of(extent%sensors)//') are not those of '// &
              record_path(scene, 1)//' ('//quantities_of(first%sensors)//'); accepted: repeats of one measurement')
  end subroutine check_sensors

  subroutine set_axes(extents, times, many_starts, layout)
    !! Sensors, and the axes of what is drawn of a record: all its samples and all frequencies of its transform where these are
    !! not too many, else stretches of them.
    type(record_extent), intent(in) :: extents(:)
    real(dp), intent(in) :: times(:)              !! of the last record
    logical, intent(in) :: many_starts            !! cases begin with different samples
    type(result_layout), intent(inout) :: layout
    associate (record => layout%record)
      record%sensors = extents(1)%sensors
      record%placed = .not. any(is_missing(extents(1)%sensors%position))
      record%unit = common_unit(extents(1))
      record%duration = maxval(extents%duration)
      layout%points = size(record%sensors)
      if (room_of(layout) < fewest_shown) return
      call set_times(extents, times, many_starts, room_of(layout), record)
      layout%samples = size(record%times)
    end associate
  end subroutine set_axes

  pure function common_unit(extent) result(unit)
    !! The unit of all sensors; `1` where they have different ones.
    type(record_extent), intent(in) :: extent
    character(:), allocatable :: unit
    integer :: s
    unit = extent%sensors(1)%unit
    do s = 2, size(extent%sensors)
      if (extent%sensors(s)%unit /= unit) unit = '1'
    end do
  end function common_unit

  subroutine set_times(extents, times, many_starts, room, record)
    !! The times that are drawn, since the first sample. Samples that all cases have in common are drawn themselves. Of others
    !! the least and the largest in each stretch of time: two values, a quarter and three quarters of it from its start.
    type(record_extent), intent(in) :: extents(:)
    real(dp), intent(in) :: times(:)              !! of the last record
    logical, intent(in) :: many_starts            !! cases begin with different samples
    integer, intent(in) :: room                   !! numbers
    type(record_layout), intent(inout) :: record
    logical :: alike
    integer :: longest, j, n
    real(dp) :: step
    longest = maxval(extents%samples)
    step = extents(1)%steps(1)
    alike = all([(all(abs(extents(j)%steps - step) <= same*step), j=1, size(extents))])
    if (size(extents) == 1 .and. .not. many_starts) alike = .true.
    record%stretched = .not. alike .or. longest > room
    if (.not. record%stretched) then
      record%times = times
      if (size(extents) > 1) record%times = [(j*step, j=0, longest - 1)]
      return
    end if
    n = 2*(min(room, 2*longest)/2)
    step = maxval(extents%duration)/(n - 1)
    record%times = [(j*step, j=0, n - 1)]
  end subroutine set_times

  pure subroutine set_frequencies(extents, steps, layout)
    !! From 0 to half the highest sampling rate, as finely as the longest record tells them apart or there is room.
    type(record_extent), intent(in) :: extents(:)
    real(dp), intent(in) :: steps(:)              !! between samples, s, (files)
    type(result_layout), intent(inout) :: layout
    real(dp) :: resolution
    integer :: bins, j
    resolution = 1/maxval(extents%duration + steps)
    bins = int(min(0.5_dp/minval(steps)/resolution + 0.01_dp, real(room_of(layout), dp)))
    if (bins >= room_of(layout)) then
      bins = room_of(layout) - 1
      resolution = 0.5_dp/(minval(steps)*bins)
    end if
    layout%record%frequencies = [(j*resolution, j=0, bins)]
    layout%frequencies = bins + 1
  end subroutine set_frequencies

  pure integer function room_of(layout) result(room)
    !! How many numbers of each sensor are drawn in each case, at most.
    type(result_layout), intent(in) :: layout
    room = most_shown/(layout%points*max(1, layout%cases))
  end function room_of

end module bw_record_plan
