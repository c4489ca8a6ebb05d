module bw_record_case
  !! A case whose histories are measured: record ► lines ► waves ► result.
  use bw_case_result, only: add_notes, case_no_free_decay, case_result, record_result
  use bw_estimated_lines, only: estimate_lines, estimated_line
  use bw_found_lines, only: found_lines
  use bw_hammer, only: find_constants, hammer_of, hammer_type
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_monitor, only: monitor_type
  use bw_note, only: remark
  use bw_order, only: quantile_of
  use bw_read_record, only: read_record
  use bw_record, only: clock_text, extent_of, record_type
  use bw_record_flaws, only: find_flaws, flaws_type
  use bw_record_lines, only: lines_in_si
  use bw_record_view, only: samples_of, take_values, view_fit, view_histories, view_response, view_spectra
  use bw_record_waves, only: find_record_waves
  use bw_result_layout, only: result_layout
  use bw_samples, only: first_valid, gaps_of, gaps_type, samples_type, validity
  use bw_scene, only: scene_type
  use bw_sensor_unit, only: si_unit
  use bw_spikes, only: leave_out_spikes
  use bw_stopwatch, only: stage_response, stage_spectrum, stopwatch
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: keep_record, run_record_case

  integer(i8), parameter, public :: few_numbers = 2_i8**22     !! of a record that stays in memory between cases: 34 MB

  type, public :: record_cache
    !! The record of the last case.
    type(record_type) :: record
    integer :: file = 0                                !! its number; 0: none
    real(dp) :: part(2) = 0                            !! first and last time, as in the scene
  end type record_cache

contains

  subroutine run_record_case(scene, layout, watch, monitor, cache, result, completed)
    !! Analyse a record.
    type(scene_type), intent(in) :: scene              !! without sweeps
    type(result_layout), intent(in) :: layout          !! completed by `plan_record`
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout) :: monitor
    type(record_cache), intent(inout) :: cache
    type(case_result), intent(out) :: result           !! with an error if the record cannot be read
    logical, intent(out) :: completed                      !! false if the monitor requested a stop before the end
    type(record_type) :: record
    type(samples_type) :: samples
    type(found_lines) :: found
    type(estimated_line), allocatable :: estimated(:)
    type(hammer_type), allocatable :: hammer
    call watch%start()
    completed = .false.
    allocate (result%notes(0))
    call take_record(scene, cache, record, result)
    if (monitor%stop_requested()) return
    completed = allocated(result%error)
    if (completed) return
    call watch%lap(stage_response)

    allocate (result%record)
    result%record%extent = extent_of(record)
    call add_notes(result%notes, record%notes)
    samples = samples_of(record)
    associate (extent => result%record%extent)
      if (.not. allocated(samples%place)) extent%steps = samples%step
      extent%absent = samples%count - extent%samples
    end associate
    call take_force(record, samples, hammer, result%notes)
    call take_values(record, samples)
    call note_spikes(scene, record, samples, result%notes)
    call view_histories(record%times, samples, layout, result%record%recorded)
    if (monitor%stop_requested()) return
    call monitor%enter('spectrum')
    call estimate_lines(samples, scene%spectrum%confidence, scene%spectrum%false_alarm, found, estimated, monitor)
    if (monitor%stop_requested()) return
    result%record%lines = lines_in_si(samples, found, estimated, scene%spectrum%confidence, scene%spectrum%max_peaks)
    if (allocated(hammer)) then
      call find_constants_of_lines(hammer, samples, result%record)
      call view_response(samples, layout, hammer, found, result%record)
    end if
    call view_spectra(samples, layout, scene%spectrum%window, found, result%amplitude, result%record%noise)
    call view_fit(record, samples, layout, found, result%record)
    if (monitor%stop_requested()) return
    call find_record_waves(scene, layout, result, monitor)
    if (monitor%stop_requested()) return
    call note_lines(scene, layout, result)
    call watch%lap(stage_spectrum)
    completed = .true.
  end subroutine run_record_case

  subroutine take_record(scene, cache, record, result)
    !! Take the record from the cache or read its file. A small one is kept for the next case.
    type(scene_type), intent(in) :: scene
    type(record_cache), intent(inout) :: cache
    type(record_type), intent(out) :: record
    type(case_result), intent(inout) :: result
    real(dp) :: part(2)
    part = [scene%record%first_time, scene%record%last_time]
    if (cache%file /= scene%record%file .or. any(abs(cache%part - part) > 0)) then
      cache%file = 0
      call read_record(scene, scene%record%file, record, result%error)
      if (allocated(result%error)) return
      call keep_record(scene, record, cache)
    end if
    if (size(cache%record%values, kind=i8) <= few_numbers) then
      record = cache%record
    else
      call move_record(cache%record, record)
      cache%file = 0
    end if
  end subroutine take_record

  subroutine keep_record(scene, record, cache)
    !! Move the record of the scene's case into the cache.
    type(scene_type), intent(in) :: scene
    type(record_type), intent(inout) :: record         !! its values are moved
    type(record_cache), intent(inout) :: cache
    call move_record(record, cache%record)
    cache%file = scene%record%file
    cache%part = [scene%record%first_time, scene%record%last_time]
  end subroutine keep_record

  subroutine move_record(from, to)
    !! Move a record, without a copy of its values.
    type(record_type), intent(inout) :: from
    type(record_type), intent(out) :: to
    real(dp), allocatable :: values(:, :)
    call move_alloc(from%values, values)
    to = from
    call move_alloc(values, to%values)
  end subroutine move_record

  pure subroutine take_force(record, samples, hammer, notes)
    !! Find the hammer's impacts, during which samples show no free decay.
    type(record_type), intent(in) :: record
    type(samples_type), intent(inout) :: samples
    type(hammer_type), allocatable, intent(out) :: hammer
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp), allocatable :: force(:)
    type(flaws_type) :: flaws
    integer, allocatable :: row(:), known(:)
    integer(i8) :: clipped
    integer :: s, j
    if (.not. allocated(record%force)) return
    if (allocated(samples%place)) then
      call append(notes, 'hammer: the force is ignored, since it needs evenly spaced samples')
      return
    end if
    force = spread(quantile_of(record%force, 0.5_dp), 1, samples%count)
    row = nint(record%force_times/samples%step) + 1
    known = pack([(j, j=1, size(row))], row >= 1 .and. row <= samples%count)
    force(row(known)) = record%force(known)
    hammer = hammer_of(force)
    if (size(hammer%after) == 0) then
      call append(notes, 'hammer: the force shows no blow, and is ignored')
      deallocate (hammer)
      return
    end if
    flaws = find_flaws(force)
    clipped = merge(flaws%clipped_high, flaws%clipped_low, sum(hammer%force) > 0)
    if (clipped > 0) call append(notes, 'hammer: the force is clipped in '//text_of(clipped)//' samples, so that modal '// &
      'constants and frequency responses are too large')
    do s = 1, size(record%values, 2)
      if (record%sensors(s)%left_out .or. all(validity(samples, s) .or. .not. hammer%acts)) cycle
      hammer%unseen = [hammer%unseen, s]
      call append(notes, 'hammer: '//record%sensors(s)%name//' has missing, clipped or constant samples or spikes during a '// &
        'blow; its frequency response is not determined')
    end do
    samples%missing = [(gaps_of(validity(samples, s) .and. .not. hammer%acts), s=1, size(record%values, 2))]
    samples%blow = hammer%after
    if (first_valid(samples) >= samples%blow(1)) samples%blow(1) = 1
  end subroutine take_force

  subroutine note_spikes(scene, record, samples, notes)
    !! Leave out samples that do not follow from those around them, and note how many.
    type(scene_type), intent(in) :: scene
    type(record_type), intent(in) :: record            !! without values
    type(samples_type), intent(inout) :: samples
    type(string), allocatable, intent(inout) :: notes(:)
    type(gaps_type) :: spikes(size(record%sensors))
    integer :: s, n, first
    call leave_out_spikes(samples, scene%spectrum%false_alarm, spikes)
    do s = 1, size(spikes)
      n = size(spikes(s)%place)
      if (n == 0) cycle
      first = spikes(s)%place(1)
      call append(notes, 'spike: '//record%sensors(s)%name//' has '//text_of(n)//trim(merge(' sample ', ' samples', n == 1))// &
        ' beside the motion before and after; left out, the first at '// &
        clock_text(record%origin + (first - 1)*samples%step, record%times(size(record%times)))//' s')
    end do
  end subroutine note_spikes

  subroutine find_constants_of_lines(hammer, samples, record)
    !! Find the modal constants of all lines at motion sensors with known units.
    type(hammer_type), intent(in) :: hammer
    type(samples_type), intent(in) :: samples
    type(record_result), intent(inout) :: record       !! whose lines are known
    complex(dp) :: constant(size(record%extent%sensors))
    real(dp) :: share
    integer :: derivative(size(constant)), k, s
    logical :: is_motion(size(constant))
    do s = 1, size(constant)
      associate (sensor => record%extent%sensors(s))
        derivative(s) = index('displacement velocity     acceleration', sensor%quantity)/13
        is_motion(s) = sensor%quantity /= 'strain' .and. sensor%unit == si_unit(sensor%quantity)
      end associate
    end do
    associate (lines => record%lines)
      allocate (record%constant_real(size(lines%decay_rate), size(constant)), source=missing)
      record%constant_imag = record%constant_real
      record%constant_error = record%constant_real
      if (size(lines%decay_rate) == 0) return
      do k = 1, size(lines%decay_rate)
        call find_constants(hammer, samples%step, samples%blow(1), cmplx(-lines%decay_rate(k), lines%angular_frequency(k), dp), &
                            derivative, lines%amplitude(:, k), constant, share)
        do s = 1, size(constant)
          if (.not. is_motion(s) .or. is_missing(lines%amplitude_bound(s, k))) cycle
          record%constant_real(k, s) = constant(s)%re
          record%constant_imag(k, s) = constant(s)%im
          record%constant_error(k, s) = lines%quantile*hypot(share*abs(constant(s)), abs(constant(s)/lines%amplitude(s, k)) &
            *max(lines%amplitude_bound(s, k), lines%phase_bound(s, k)*abs(lines%amplitude(s, k))))
        end do
      end do
    end associate
  end subroutine find_constants_of_lines

  subroutine note_blows(record, notes)
    !! Note when the beam was struck, unless only at the first sample.
    type(record_result), intent(in) :: record
    type(string), allocatable, intent(inout) :: notes(:)
    character(:), allocatable :: text
    integer :: b
    if (size(record%lines%angular_frequency) == 0) return
    if (record%lines%contact > 0) call remark(notes, 'contact: the first '//shortest(record%lines%contact, 3)//' s after each '// &
      'blow are no free decay and are left out')
    if (size(record%lines%blow) == 1 .and. .not. record%lines%blow(1) > 0) return
    text = ''
    do b = 1, size(record%lines%blow)
      text = text//', '//clock_text(record%extent%origin + record%lines%blow(b), record%extent%duration)
    end do
    if (size(record%lines%blow) == 1) then
      call remark(notes, 'blow: found at '//text(3:)//' s; the samples before it determine the noise')
    else
      call remark(notes, 'blows: found at '//text(3:)//' s; amplitudes refer to the first')
    end if
  end subroutine note_blows

  subroutine note_lines(scene, layout, result)
    !! Note what concerns the lines.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_result), intent(inout) :: result
    integer :: s
    associate (lines => result%record%lines)
      do s = 1, size(lines%own)
        if (is_missing(lines%noise_deviation(s)) .or. lines%own(s) .or. .not. lines%noise_deviation(s) > 0) cycle
        call append(result%notes, 'copy: the samples of '//result%record%extent%sensors(s)%name//' are a multiple of those of '// &
                    'an earlier sensor; noise and waves are estimated without them')
      end do
      call note_blows(result%record, result%notes)
      if (lines%driven) then
        result%status = case_no_free_decay
        call append(result%notes, 'no free decay: the beam seems to be driven continuously: coloured noise explains the motion '// &
          'better than decaying lines, or these leave a residual that grows. If a part of the record is a decay after a '// &
          'blow, select it by start and end; a driven motion needs operational modal analysis, which this program does not do')
      else if (size(lines%angular_frequency) == 0) then
        call append(result%notes, 'no line: nothing exceeds the noise by more than happens by chance in one of '// &
          shortest(1/scene%spectrum%false_alarm, 3)//' records')
      end if
      if (.not. lines%converged) call append(result%notes, 'the search for lines was stopped before it had converged: some may '// &
        'be missing, and weak ones may be parts of stronger ones that change as they decay')
      if (lines%left_out > 0) call remark(result%notes, 'max_peaks: the '//text_of(lines%left_out)//' weakest of '// &
        text_of(lines%left_out + size(lines%angular_frequency))//' lines are not listed; max_peaks = '// &
        text_of(lines%left_out + size(lines%angular_frequency))//' lists them')
    end associate
    if (size(scene%record%files) > 1 .and. layout%pooled == 0) call remark(result%notes, 'repeats: they are not pooled, since '// &
      'there is another &sweep; each file is a separate case for each of its values')
  end subroutine note_lines

end module bw_record_case
