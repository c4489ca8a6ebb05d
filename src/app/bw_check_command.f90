module bw_check_command
  !! The command `check`: what scenes simulate, by which method, the time and memory needed, and the warnings of a run.
  use bw_case_modes, only: first_modes
  use bw_case_tolerance, only: fix_tolerance
  use bw_check_json, only: check_document, good_scene, refused_scene, scene_facts
  use bw_command_table, only: command_type
  use bw_console, only: print_error, print_report, print_warning, print_warnings, seen_together
  use bw_error, only: error_type, fail, status_done, status_not_trusted, status_stopped
  use bw_forecast, only: few_modes, few_samples, forecast_notes, forecast_type, takes_at_most
  use bw_further_scenes, only: further_scenes
  use bw_kinds, only: dp, i8
  use bw_modes_par, only: by_tolerance, default_tolerance, is_relaxed
  use bw_monitor, only: monitor_type
  use bw_process, only: free_disk, free_memory
  use bw_record, only: record_extent, record_type
  use bw_record_plan, only: plan_record
  use bw_load_courses, only: check_load_files
  use bw_record_summary, only: record_summary
  use bw_report, only: notes_report
  use bw_result_layout, only: result_layout, layout_of
  use bw_scene, only: converges_in_run, is_loaded, scene_type
  use bw_scene_files, only: read_and_list, refused_type
  use bw_scene_summary, only: bytes_text, case_numbers, cost_summary, disk_bytes, scene_heading, &
    & scene_summary, unknowns_text, working_bytes
  use bw_scene_tally, only: scene_tally, warning_kinds
  use bw_stopwatch, only: wall_seconds
  use bw_terminal_progress, only: duration_text, terminal_progress, terminal_progress_to
  use bw_text, only: append, shortest, string, text_of
  use bw_time_estimate, only: estimated_seconds, record_seconds
  implicit none (type, external)
  private
  public :: check_command

  real(dp), parameter :: most_planning = 1.0_dp      !! s, by the cost model, for a first try at a tolerance
  real(dp), parameter :: patience = 6.0_dp           !! s for a scene; a record is read completely
  character(*), parameter :: time_head = '  time       '
  character(*), parameter :: untried = '  tried      nothing: warnings are known only after a run'

contains

  integer function check_command(command) result(status)
    !! Describe each valid scene; list the errors of the others.
    type(command_type), intent(in) :: command
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress            ! shows nothing; requests a stop after a signal
    type(error_type), allocatable :: error
    type(scene_tally) :: tally
    type(scene_facts) :: facts
    type(result_layout) :: layout
    type(refused_type), allocatable :: refused(:)
    type(string), allocatable :: objects(:)
    character(:), allocatable :: text
    integer :: i, count
    logical :: seen                                ! the report has shown the warnings to the same reader
    progress = terminal_progress_to(huge(1.0_dp), quiet=.true.)
    call read_and_list(command%words, .not. command%json, scenes, count, status, tally, refused)
    allocate (objects(0))
    do i = 1, count
      call examine(scenes(i), tally%is_brief(), layout, facts, text, error)
      if (progress%stop_requested()) then
        if (.not. command%json) call print_warning('beamwave: stopped before '//scenes(i)%file//' was checked')
        status = max(status, status_stopped)
        exit
      else if (allocated(error)) then
        if (command%json) call append(objects, refused_scene(scenes(i)%file, error%status, error%message))
        if (.not. command%json) call print_error(error)
        status = max(status, error%status)
        call tally%count_end(error%status, facts%notes)
        cycle
      else if (command%json) then
        call append(objects, good_scene(scenes(i), layout, facts))
        cycle
      else if (.not. command%quiet) then
        call print_report(text)
      end if
      call tally%count_end(status_done, facts%notes)
      seen = .false.
      if (.not. command%quiet) seen = seen_together()
      if (.not. seen) call print_warnings(scenes(i), facts%notes)
    end do
    if (command%json) then
      do i = 1, size(refused)
        call append(objects, refused_scene(refused(i)%file, refused(i)%status, refused(i)%message))
      end do
      call print_report(check_document(objects, status))
    else if (.not. command%quiet) then
      call print_report(tally%text('good'))
    end if
  end function check_command

  subroutine examine(scene, brief, layout, facts, text, error)
    !! Describe a scene.
    !! **Errors**: its tolerance is unattainable; a file of its record or its loads is bad.
    type(scene_type), intent(inout) :: scene       !! as in `plan_tolerance`
    logical, intent(in) :: brief                   !! in one line
    type(result_layout), intent(out) :: layout
    type(scene_facts), intent(out) :: facts
    character(:), allocatable, intent(out) :: text !! printed for a valid scene
    type(error_type), allocatable, intent(out) :: error
    type(terminal_progress) :: monitor             ! limits the time of trial runs
    character(:), allocatable :: count_line, time_line
    integer :: planned
    layout = layout_of(scene)
    text = ''
    facts%notes = ''
    if (allocated(scene%record)) then
      call check_records(scene, layout, count_line, facts%notes, error)
      if (allocated(error)) return
      facts%seconds = record_seconds(scene, layout)
      time_line = time_head//'about '//expected_text(facts%seconds)// &
        ' on one core, more if there are many lines or they drift'
      if (size(scene%unknowns) > 0) time_line = time_line//' or the model does not explain them'
      time_line = time_line//new_line('a')
    else
      if (is_loaded(scene)) call check_load_files(scene, layout%load_checksums, error)
      if (allocated(error)) return
      monitor = terminal_progress_to(wall_seconds() + patience, quiet=.true.)
      call plan_tolerance(scene, monitor, planned, count_line, error)
      if (allocated(error)) return
      facts%modes = max(scene%modes%before, scene%modes%after)
      if (by_tolerance(scene%modes)) facts%modes = merge(0, planned, count_line == '')
      call foresee(scene, layout, planned, monitor, time_line, facts)
    end if
    facts%memory = working_bytes(scene, layout)
    facts%disk = disk_bytes(scene, layout)
    facts%notes = room_notes(facts)//facts%notes
    if (brief) then
      text = scene%file//': good, takes '//time_line(len(time_head) + 1:index(time_line, new_line('a')) - 1)
      if (warning_kinds(facts%notes) /= '') text = text//'; warnings: '//warning_kinds(facts%notes)
    else
      text = scene_heading(scene)//scene_summary(scene, layout, hint=index(time_line, untried) == 0)//count_line
      text = text//cost_summary(scene, layout, facts%memory)//time_line
      if (facts%notes /= '') text = text//new_line('a')//notes_report(facts%notes(:len(facts%notes) - 1))
    end if
  end subroutine examine

  subroutine foresee(scene, layout, planned, monitor, time_line, facts)
    !! Predict the time of a run by the cost model, and its warnings from trial cases.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer, intent(in) :: planned                 !! modes that a tolerance needs
    class(monitor_type), intent(inout) :: monitor
    character(:), allocatable, intent(out) :: time_line
    type(scene_facts), intent(inout) :: facts      !! receives seconds and notes
    type(forecast_type) :: forecast
    if (monitor%stop_requested()) then
      time_line = time_head//'more than '//expected_text(patience)//', the time of its planning alone'//new_line('a')// &
        untried//new_line('a')
      return
    end if
    facts%seconds = estimated_seconds(scene, case_numbers(scene, layout), planned, monitor)
    time_line = time_head//'about '//expected_text(facts%seconds)//' on one core'
    if (allocated(scene%contact)) time_line = time_line//', more if there are many contacts'
    if (layout%cases > 1) time_line = time_line//', shared by the processes of beamwave-mpi'
    time_line = time_line//new_line('a')
    call forecast_notes(scene, layout, planned, monitor, forecast)
    facts%notes = forecast%notes%lines(merge(forecast%cases, 0, layout%cases > 0))
    if (forecast%cases == 0) then
      time_line = time_line//untried//new_line('a')
    else if (forecast%from_few) then
      time_line = time_line//'  tried      at most '//text_of(few_modes)//' modes'
      if (allocated(scene%response)) time_line = time_line//' and '//text_of(few_samples)// &
        ' samples; errors of histories are known only after a run'
      time_line = time_line//new_line('a')
    else if (layout%cases > forecast%cases) then
      time_line = time_line//'  tried      '//text_of(forecast%cases)//' of '//text_of(layout%cases)//' cases'
      if (facts%notes /= '') time_line = time_line//', to which these notes refer'
      time_line = time_line//new_line('a')
    end if
  end subroutine foresee

  function room_notes(facts) result(notes)
    !! Compare the memory and disk space that a run needs with those of this machine: a line for each shortage.
    type(scene_facts), intent(in) :: facts
    character(:), allocatable :: notes
    integer(i8) :: memory, disk
    memory = free_memory()
    disk = free_disk('.')
    notes = ''
    if (memory >= 0 .and. facts%memory > memory) notes = notes//'memory: a run needs '//bytes_text(facts%memory)// &
      ', but this machine has '//bytes_text(memory)//' free'//new_line('a')
    if (disk >= 0 .and. facts%disk > disk) notes = notes//'disk: a run needs '//bytes_text(facts%disk)// &
      ', but only '//bytes_text(disk)//' are free here'//new_line('a')
  end function room_notes

  pure function expected_text(seconds) result(text)
    !! Format seconds like `duration_text`, with one more digit if whole seconds are too coarse.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds >= 1.0_dp .and. seconds < 10.0_dp) then
      text = shortest(seconds, 2)//' s'
    else
      text = duration_text(seconds)
    end if
  end function expected_text

  subroutine check_records(scene, layout, text, notes, error)
    !! Read every file of a record, and those of the scenes fitted with it, and describe their content.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(inout) :: layout   !! completed by the files
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
    !! Describe the content of one record's files.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(inout) :: layout   !! completed by the files
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

  subroutine plan_tolerance(scene, monitor, count, text, error)
    !! Report how many modes a tolerance needs, unless cases of a sweep differ or planning takes too long.
    type(scene_type), intent(inout) :: scene       !! its default tolerance is relaxed if unattainable
    class(monitor_type), intent(inout) :: monitor  !! nothing is planned if it asks to stop
    integer, intent(out) :: count                  !! of modes; a guess if not planned
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    text = ''
    count = first_modes
    if (converges_in_run(scene) .or. .not. takes_at_most(scene, first_modes, most_planning)) return
    call fix_tolerance(scene, monitor, count, error)
    if (monitor%stop_requested() .or. .not. by_tolerance(scene%modes) .or. size(scene%sweeps) > 0) return
    if (.not. allocated(error) .and. count == 0) call fail(error, status_not_trusted, scene%file//': not converged: the '// &
      'polynomials of the Galerkin basis do not resolve the modes; all numbers of the case would be missing')
    if (allocated(error)) return
    text = '  modes      about '//text_of(count)//' to be summed'
    if (is_relaxed(scene%modes)) text = text//'; the default tolerance '//shortest(default_tolerance, 2)//' is out of reach'
    text = text//new_line('a')
  end subroutine plan_tolerance

end module bw_check_command
