module bw_check_command
  !! The command that says what scenes would simulate, by which method, what that would take, and what a run would warn of.
  use bw_case_shares, only: case_bytes
  use bw_case_tolerance, only: fix_tolerance
  use bw_child_process, only: child_process
  use bw_command_table, only: command_type
  use bw_console, only: print_error, print_report, print_warning, print_warnings, seen_together
  use bw_error, only: error_type, fail, status_done, status_not_trusted, status_stopped
  use bw_forecast, only: few_modes, few_samples, forecast_type, most_trial_bytes
  use bw_further_scenes, only: further_scenes
  use bw_kinds, only: dp, i8
  use bw_modes_par, only: by_tolerance, default_tolerance, is_relaxed
  use bw_monitor, only: monitor_type
  use bw_process, only: free_disk, free_memory, peak_memory
  use bw_record, only: record_extent, record_type
  use bw_record_plan, only: plan_record
  use bw_record_summary, only: record_summary
  use bw_report, only: notes_report
  use bw_result_layout, only: result_layout, layout_of
  use bw_scene, only: scene_type
  use bw_scene_files, only: read_and_list
  use bw_scene_summary, only: bytes_text, cost_summary, disk_bytes, record_seconds, scene_heading, scene_summary, &
    & unknowns_text, working_bytes
  use bw_scene_tally, only: scene_tally, warning_kinds
  use bw_stopwatch, only: wall_seconds
  use bw_terminal_progress, only: duration_text, terminal_progress, terminal_progress_to
  use bw_text, only: append, shortest, string, text_of
  use bw_time_estimate, only: estimated_seconds, fits
  implicit none (type, external)
  private
  public :: check_command

  real(dp), parameter :: check_seconds = 2.0_dp        !! what `check` may take to try cases of all its scenes
  real(dp), parameter :: most_check_seconds = 1.0_dp   !! and of one of them
  real(dp), parameter :: most_scene_seconds = 6.0_dp   !! for all that is tried of a scene; half more ends what does not stop
  character(*), parameter :: untried = '  tried      nothing to its end: only a run tells what it warns of'

contains

  integer function check_command(command) result(status)
    !! Say what each good scene would simulate; list what is wrong with the others.
    type(command_type), intent(in) :: command
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress            ! shows nothing: it asks to stop after a signal
    type(error_type), allocatable :: error
    type(scene_tally) :: tally
    character(:), allocatable :: text, notes
    real(dp) :: left, began                        ! s: of the time for all scenes, which most do not need
    integer :: i, count
    logical :: seen                                ! the report has shown the warnings to the same eyes
    left = check_seconds
    progress = terminal_progress_to(huge(1.0_dp), quiet=.true.)
    call read_and_list(command%words, .true., scenes, count, status, tally)
    do i = 1, count
      began = wall_seconds()
      call examine_apart(scenes(i), tally%is_brief(), max(0.5_dp*left, check_seconds/count), text, notes, error)
      left = left - (wall_seconds() - began)
      if (progress%stop_requested()) then
        call print_warning('beamwave: stopped before '//scenes(i)%file//' was checked')
        status = max(status, status_stopped)
        exit
      else if (allocated(error)) then
        call print_error(error)
        status = max(status, error%status)
        call tally%count_end(error%status, notes)
        cycle
      else if (.not. command%quiet) then
        call print_report(text)
      end if
      call tally%count_end(status_done, notes)
      seen = .false.
      if (.not. command%quiet) seen = seen_together()
      if (.not. seen) call print_warnings(scenes(i), notes)
    end do
    if (.not. command%quiet) call print_report(tally%text('good'))
  end function check_command

  subroutine examine_apart(scene, brief, budget, text, notes, error)
    !! Examine a scene in a process of its own, which can be ended whatever it is at: a check has an end.
    !! **Errors**: those of `examine`, or that the process did not come to its end.
    type(scene_type), intent(inout) :: scene       !! as that of `plan_tolerance`
    logical, intent(in) :: brief                   !! in one line
    real(dp), intent(in) :: budget                 !! as that of `try_scene`
    character(:), allocatable, intent(out) :: text !! what is printed of a good scene
    character(:), allocatable, intent(out) :: notes   !! lines of their own
    type(error_type), allocatable, intent(out) :: error
    type(child_process) :: child
    type(terminal_progress) :: patience            ! after which what was tried has to do
    type(string), allocatable :: texts(:)
    type(result_layout) :: layout
    logical :: whole
    child%calculates = .not. allocated(scene%record)
    patience = patience_for(scene, most_scene_seconds)
    call child%begin()
    if (child%is_here()) then
      call examine(scene, brief, budget, patience, texts, error)
      call child%tell(texts, error)
    end if
    patience = patience_for(scene, 1.5_dp*most_scene_seconds)
    call child%hear(texts, whole, error, patience)
    text = ''
    notes = ''
    if (allocated(error)) return
    if (whole) then
      text = texts(1)%text
      notes = texts(2)%text
    else
      layout = layout_of(scene)
      text = checked_text(scene, layout, '', untried//new_line('a'), '', working_bytes(scene, layout), brief, hint=.false.)
    end if
  end subroutine examine_apart

  type(terminal_progress) function patience_for(scene, seconds) result(patience)
    !! A progress that asks to stop after some time; a record is read to its end.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: seconds
    patience = terminal_progress_to(merge(huge(1.0_dp), wall_seconds() + seconds, allocated(scene%record)), quiet=.true.)
  end function patience_for

  subroutine examine(scene, brief, budget, monitor, texts, error)
    !! Find what is printed of a scene, and its notes: two texts.
    !! **Errors**: its tolerance is out of reach; a file of its record is bad.
    type(scene_type), intent(inout) :: scene       !! as that of `plan_tolerance`
    logical, intent(in) :: brief
    real(dp), intent(in) :: budget
    class(monitor_type), intent(inout) :: monitor  !! less is found where it asks to stop
    type(string), allocatable, intent(out) :: texts(:)
    type(error_type), allocatable, intent(out) :: error
    type(result_layout) :: layout
    character(:), allocatable :: count_line, time_line, notes
    integer(i8) :: bytes
    layout = layout_of(scene)
    if (allocated(scene%record)) then
      call check_records(scene, layout, count_line, notes, error)
      if (allocated(error)) return
      bytes = working_bytes(scene, layout)
      time_line = '  time       about '//expected_text(record_seconds(layout))// &
        ' on one core, more where lines are many or drift'//new_line('a')
    else
      count_line = ''
      if (case_bytes(scene) <= most_trial_bytes) call plan_tolerance(scene, monitor, count_line, error)
      if (allocated(error)) return
      call try_scene(scene, layout, budget, monitor, time_line, notes, bytes)
    end if
    notes = room_notes(scene, layout, bytes)//notes
    allocate (texts(0))
    call append(texts, checked_text(scene, layout, count_line, time_line, notes, bytes, brief, &
                                    hint=.not. monitor%stop_requested()))
    call append(texts, notes)
  end subroutine examine

  function checked_text(scene, layout, count_line, time_line, notes, bytes, brief, hint) result(text)
    !! What is printed of a good scene; of one of many a line.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: count_line, time_line, notes     !! lines of their own; empty where there are none
    integer(i8), intent(in) :: bytes               !! of memory
    logical, intent(in) :: brief
    logical, intent(in), optional :: hint          !! as that of `scene_summary`
    character(:), allocatable :: text
    if (brief) then
      text = scene%file//': good'
      if (index(time_line, 'about') > 0) &
        text = text//', takes '//time_line(index(time_line, 'about'):index(time_line, new_line('a')) - 1)
      if (warning_kinds(notes) /= '') text = text//'; warnings: '//warning_kinds(notes)
    else
      text = scene_heading(scene)//scene_summary(scene, layout, hint)//count_line
      text = text//cost_summary(scene, layout, bytes)//time_line
      if (notes /= '') text = text//new_line('a')//notes_report(notes(:len(notes) - 1))
    end if
  end function checked_text

  subroutine try_scene(scene, layout, budget, monitor, time_line, notes, bytes)
    !! Run cases of a scene, as many as there is time for: how long it would take, what it would warn of, and its memory.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    real(dp), intent(in) :: budget                 !! for that, s
    class(monitor_type), intent(inout) :: monitor
    character(:), allocatable, intent(out) :: time_line, notes
    integer(i8), intent(out) :: bytes
    type(forecast_type) :: forecast
    real(dp) :: seconds
    seconds = estimated_seconds(scene, layout, min(budget, most_check_seconds), monitor, forecast)
    time_line = '  time       about '//expected_text(seconds)//' on one core'
    if (layout%cases > 1) time_line = time_line//', shared by the processes of beamwave-mpi'
    time_line = time_line//new_line('a')
    notes = forecast%notes%lines(merge(size(forecast%cases), 0, layout%cases > 0))
    bytes = working_bytes(scene, layout)
    if (size(forecast%cases) == 0) then
      time_line = time_line//untried//new_line('a')
      return
    end if
    if (.not. forecast%from_few) bytes = max(bytes, peak_memory())
    if (forecast%from_few) then
      time_line = time_line//'  tried      '//text_of(few_modes)//' modes and '//text_of(few_samples)// &
        ' samples; only a run tells the errors of histories'//new_line('a')
    else if (layout%cases > size(forecast%cases)) then
      time_line = time_line//'  tried      '//text_of(size(forecast%cases))//' of '//text_of(layout%cases)//' cases'
      if (notes /= '') time_line = time_line//', of which these notes are'
      time_line = time_line//new_line('a')
    end if
  end subroutine try_scene

  function room_notes(scene, layout, bytes) result(notes)
    !! Whether the machine has the memory and the disk that a run takes, where the check is made: a line for what it lacks.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer(i8), intent(in) :: bytes               !! of memory
    character(:), allocatable :: notes
    integer(i8) :: memory, disk
    memory = free_memory()
    disk = free_disk('.')
    notes = ''
    if (.not. fits(bytes, memory)) notes = notes//'memory: a run takes '//bytes_text(bytes)// &
      ', and this machine has '//bytes_text(memory)//' free'//new_line('a')
    if (.not. fits(disk_bytes(scene, layout), disk)) notes = notes//'disk: a run takes '//bytes_text(disk_bytes(scene, layout))// &
      ', and here '//bytes_text(disk)//' are free'//new_line('a')
  end function room_notes

  pure function expected_text(seconds) result(text)
    !! Seconds as `duration_text` writes them, with a digit more where whole seconds would be too coarse.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds >= 1.0_dp .and. seconds < 10.0_dp) then
      text = shortest(seconds, 2)//' s'
    else
      text = duration_text(seconds)
    end if
  end function expected_text

  subroutine check_records(scene, layout, text, notes, error)
    !! Read every file of a record, and those of the scenes that are fitted with it: what there is.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(inout) :: layout   !! gets what the files tell
    character(:), allocatable, intent(out) :: text, notes
    type(error_type), allocatable, intent(out) :: error
    type(scene_type), allocatable :: further(:)
    type(result_layout) :: beside
    integer :: i
    text = ''
    notes = ''
    call add_files(scene, layout, text, notes, error)
    if (.not. allocated(error)) call further_scenes(scene, further, error)
    if (allocated(error)) return
    do i = 1, size(further)
      text = text//'  with       '//further(i)%file//new_line('a')//unknowns_text(further(i))
      beside = layout_of(further(i))
      call add_files(further(i), beside, text, notes, error)
      if (allocated(error)) return
    end do
  end subroutine check_records

  subroutine add_files(scene, layout, text, notes, error)
    !! Say what the files of one record hold.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(inout) :: layout   !! gets what the files tell
    character(:), allocatable, intent(inout) :: text, notes
    type(error_type), allocatable, intent(out) :: error
    type(record_extent), allocatable :: extents(:)
    type(record_type) :: record
    integer :: f, n
    call plan_record(scene, layout, extents, record, error)
    if (allocated(error)) return
    do f = 1, size(extents)
      text = text//record_summary(extents(f))
      do n = 1, size(extents(f)%notes)
        notes = notes//extents(f)%notes(n)%text
        if (size(extents) > 1) notes = notes//' ('//extents(f)%path//')'
        notes = notes//new_line('a')
      end do
    end do
  end subroutine add_files

  subroutine plan_tolerance(scene, monitor, text, error)
    !! Say how many modes a tolerance takes, unless cases of a sweep take different ones.
    type(scene_type), intent(inout) :: scene       !! its default tolerance relaxes where it is out of reach
    class(monitor_type), intent(inout) :: monitor  !! nothing is planned where it asks to stop
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    integer :: count
    text = ''
    call fix_tolerance(scene, monitor, count, error)
    if (monitor%stop_requested() .or. .not. by_tolerance(scene%modes) .or. size(scene%sweeps) > 0) return
    if (.not. allocated(error) .and. count == 0) call fail(error, status_not_trusted, scene%file//': not converged: '// &
      'the polynomials of the Galerkin basis do not resolve the modes; no number of the case would be given')
    if (allocated(error)) return
    text = '  modes      about '//text_of(count)//' to be summed'
    if (is_relaxed(scene%modes)) text = text//'; the default tolerance '//shortest(default_tolerance, 2)//' is out of reach'
    text = text//new_line('a')
  end subroutine plan_tolerance

end module bw_check_command
