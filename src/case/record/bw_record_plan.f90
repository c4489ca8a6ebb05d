module bw_record_plan
  !! The axes of a record's result, which depend on its files. All files are read before any analysis, so a bad one is
  !! rejected before work is lost.
  use bw_error, only: error_type, fail, status_bad_input
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_order, only: quantile_of
  use bw_read_record, only: read_record, record_path
  use bw_record, only: clock_text, extent_of, measure_the_same, quantities_of, record_extent, record_type
  use bw_record_checksum, only: record_checksums
  use bw_record_view, only: step_of
  use bw_result_layout, only: record_layout, result_layout
  use bw_sample_times, only: used_part
  use bw_scene, only: scene_type
  use bw_spectrum_par, only: least_samples
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: plan_record

  integer, parameter :: most_shown = 200000
    !! numbers of a plotted array in a result, all cases together: 1.6 MB
  integer, parameter :: fewest_shown = 64         !! of a sensor in one case; fewer are not plotted
  integer, parameter :: most_even = 64            !! tuned: samples of the even grid over those that exist
  real(dp), parameter :: same = 1.0e-12_dp        !! relative tolerance of intervals

contains

  subroutine plan_record(scene, layout, extents, record, error)
    !! Read all files of a record, and complete the layout of its result.
    !! **Errors**: those of `read_record`; `status_bad_input` if repeats have other sensors, or a case too few samples.
    type(scene_type), intent(in) :: scene         !! with a record
    type(result_layout), intent(inout) :: layout
    type(record_extent), allocatable, intent(out) :: extents(:)   !! (files); with sweeps of the longest part
    type(record_type), intent(out) :: record      !! of the last file
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
    !! Return the values of an input.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: parameter
    real(dp), intent(in) :: value                 !! unless it is swept
    real(dp), allocatable :: values(:)
    integer :: i
    values = [value]
    do i = 1, size(scene%sweeps)
      if (scene%sweeps(i)%parameter == parameter) values = scene%sweeps(i)%values
    end do
  end function values_of

  subroutine check_parts(scene, record, error)
    !! Check that the part of each case has enough samples. **Errors**: `status_bad_input`.
    type(scene_type), intent(in) :: scene
    type(record_type), intent(in) :: record       !! the longest part
    type(error_type), allocatable, intent(inout) :: error
    real(dp), allocatable :: starts(:), ends(:)
    integer(i8) :: first, last
    integer :: i, j
    starts = values_of(scene, 'record%start', scene%record%first_time)
    ends = values_of(scene, 'record%end', scene%record%last_time)
    if (size(starts) == 1 .and. size(ends) == 1) return      ! the only part is the record
    do i = 1, size(starts)
      do j = 1, size(ends)
        call used_part(record%times, starts(i) - record%origin, ends(j) - record%origin, first, last)
        call check_gaps(record, int(first), int(last), error)
        if (allocated(error)) return
        if (last - first + 1 >= least_samples) cycle
        call fail(error, status_bad_input, scene%file//': &sweep: of '//record%path//' '//text_of(max(0_i8, last - first + 1))// &
                  ' samples remain '//part_text(starts(i), ends(j))//'; accepted: '//text_of(least_samples)//' or more')
        return
      end do
    end do
  end subroutine check_parts

  subroutine check_gaps(record, first, last, error)
    !! Check that uneven samples have no long gaps, as the search for lines needs the memory of an even grid.
    !! **Errors**: `status_bad_input`, with the longest gap.
    type(record_type), intent(in) :: record
    integer, intent(in) :: first, last            !! of the samples
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: steps(max(0, last - first)), even ! s; samples of the even grid
    integer :: at
    if (record%interval > 0 .or. last - first < least_samples) return
    steps = record%times(first + 1:last) - record%times(first:last - 1)
    even = sum(steps)/quantile_of(steps, 0.5_dp)
    if (even <= most_even*size(steps)) return
    at = first + maxloc(steps, dim=1)
    call fail(error, status_bad_input, record%path//': has no samples between '//time_text(at - 1)//' and '//time_text(at)// &
              ' s, and '//text_of(last - first + 1)//' in total, while '//shortest(even, 3)//' at their usual interval would '// &
              'fill the time; accepted: up to '//text_of(most_even)//' times fewer; start or end cuts off the part beyond a gap')
  contains
    function time_text(sample) result(text)
      integer, intent(in) :: sample
      character(:), allocatable :: text
      text = clock_text(record%origin + record%times(sample), record%times(last) - record%times(first))
    end function time_text
  end subroutine check_gaps

  pure function part_text(start, end) result(text)
    !! Return a part of a record in words.
    real(dp), intent(in) :: start, end            !! s
    character(:), allocatable :: text
    text = ''
    if (start > -huge(start)) text = 'from start = '//shortest(start, 6)
    if (start > -huge(start) .and. end < huge(end)) text = text//' '
    if (end < huge(end)) text = text//'up to end = '//shortest(end, 6)
  end function part_text

  subroutine check_sensors(scene, extent, first, error)
    !! Check that repeats have the same sensors. **Errors**: `status_bad_input`.
    type(scene_type), intent(in) :: scene
    type(record_extent), intent(in) :: extent, first
    type(error_type), allocatable, intent(inout) :: error
    if (measure_the_same(extent%sensors, first%sensors)) return
    call fail(error, status_bad_input, extent%path//': its sensors ('//quantities_of(extent%sensors)//') are not those of '// &
              record_path(scene, 1)//' ('//quantities_of(first%sensors)//'); accepted: repeats of one measurement')
  end subroutine check_sensors

  subroutine set_axes(extents, times, many_starts, layout)
    !! Set the sensors and the time axis of plots: all samples if there are not too many, else intervals.
    type(record_extent), intent(in) :: extents(:)
    real(dp), intent(in) :: times(:)              !! of the last record
    logical, intent(in) :: many_starts            !! cases start at different samples
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
    !! Return the unit of all sensors; `1` if they differ.
    type(record_extent), intent(in) :: extent
    character(:), allocatable :: unit
    integer :: s
    unit = extent%sensors(1)%unit
    do s = 2, size(extent%sensors)
      if (extent%sensors(s)%unit /= unit) unit = '1'
    end do
  end function common_unit

  subroutine set_times(extents, times, many_starts, room, record)
    !! Set the plotted times since the first sample. If samples of all cases coincide, they are plotted; else the
    !! smallest and the largest in each interval, at a quarter and three quarters of it.
    type(record_extent), intent(in) :: extents(:)
    real(dp), intent(in) :: times(:)              !! of the last record
    logical, intent(in) :: many_starts            !! cases start at different samples
    integer, intent(in) :: room                   !! most numbers
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
    !! Set frequencies from 0 to the highest Nyquist frequency, with the resolution of the longest record, or as many as fit.
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
    !! Return the most numbers plotted for each sensor and case.
    type(result_layout), intent(in) :: layout
    room = most_shown/(layout%points*max(1, layout%cases))
  end function room_of

end module bw_record_plan
