module bw_run_scene
  !! A scene from what is there already to its finished file. A scene without sweeps has one case, which goes straight into its
  !! file; the cases of sweeps are `bw_run_sweep`'s.
  use bw_case_fields, only: case_field, fields_of, forbid_lost
  use bw_case_result, only: case_done, case_result
  use bw_case_tolerance, only: settle_tolerance
  use bw_child_process, only: child_process
  use bw_error, only: error_type, fail, status_bad_file
  use bw_existing_result, only: existing_result, look_at_existing
  use bw_kinds, only: dp, i1, i4, i8
  use bw_modes_par, only: is_relaxed
  use bw_monitor, only: monitor_type, progress_type
  use bw_notes, only: notes_type
  use bw_one_case, only: case_cache, run_case
  use bw_outcome, only: outcome_type, work_taken_away
  use bw_process_group, only: process_group
  use bw_record, only: record_extent, record_type
  use bw_record_case, only: keep_record
  use bw_record_plan, only: plan_record
  use bw_report, only: case_report
  use bw_result_file, only: create_result, result_file
  use bw_result_header, only: source_text
  use bw_result_layout, only: layout_of
  use bw_result_supplement, only: result_supplement
  use bw_run_sweep, only: run_sweep
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_summary, only: bytes_text, working_bytes
  use bw_stage_report, only: stage_report
  use bw_stopwatch, only: stage_spectrum, stage_write, stopwatch, wall_seconds
  use bw_text, only: string, text_of
  use bw_unfinished_work, only: unfinished_work
  implicit none (type, external)
  private
  public :: run_scene

contains

  subroutine run_scene(scene, directory, overwrite, group, progress, outcome, error, supplement)
    !! Run all cases of a scene, write DIRECTORY/<scene>.nc, and say how it went. Called by all processes; the leader gets
    !! the outcome.
    !! **Errors**: `status_bad_file` where a file cannot be read or written or is another scene's.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(process_group), intent(inout) :: group
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    class(result_supplement), intent(inout), optional :: supplement    !! what else belongs into the result
    type(unfinished_work) :: work
    type(record_extent), allocatable :: extents(:)
    type(record_type) :: record                 ! the last that was read
    real(dp) :: nothing(0)
    logical :: is_sweep
    integer(i4), allocatable :: go(:)           ! its size: 1 where there is work to do
    work%scene = scene
    work%layout = layout_of(scene)
    is_sweep = work%layout%cases > 0
    if (.not. (is_sweep .or. group%leads())) return
    outcome%file = directory//'/'//scene%name//'.nc'
    outcome%notes = ''
    if (allocated(scene%record)) then
      call plan_record(scene, work%layout, extents, record, error)
      if (is_sweep) call group%collect(nothing, error)
      if (allocated(error)) return
    end if
    call work%plan(outcome%file, overwrite)
    work%identity = source_text()//new_line('a')//resolved_text(scene)//new_line('a')//fields_text(fields_of(work%layout))
    if (allocated(work%layout%record)) work%identity = work%identity//work%layout%record%checksums//new_line('a')
    allocate (go(0))
    if (group%leads()) call look_first(work, progress, outcome, go, error)
    if (is_sweep) call group%share(go)
    if (size(go) == 0) return
    if (is_sweep) then
      call run_sweep(work, group, progress, outcome, error, supplement)
    else
      call run_single(work, record, progress, outcome, error, supplement)
    end if
  end subroutine run_scene

  pure function fields_text(fields) result(text)
    !! The numbers of a case in their order, as a journal has them, as text: their names and lengths.
    type(case_field), intent(in) :: fields(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(fields)
      text = text//trim(fields(i)%name)//' '//text_of(fields(i)%length)//new_line('a')
    end do
  end function fields_text

  subroutine look_first(work, monitor, outcome, go, error)
    !! Find out whether there is something to do, and room to do it; then take the lock of the work.
    type(unfinished_work), intent(inout) :: work
    class(monitor_type), intent(inout) :: monitor
    type(outcome_type), intent(inout) :: outcome
    integer(i4), allocatable, intent(inout) :: go(:)
    type(error_type), allocatable, intent(out) :: error
    type(existing_result) :: existing
    type(error_type), allocatable :: refused
    integer :: ignored
    call look_at_existing(outcome%file, work%scene, work%overwrite, existing, error, record=checksums_of(work))
    if (.not. existing%is_there .and. .not. (allocated(error) .and. work%scene%modes%asked)) then
      call settle_tolerance(work%scene, monitor, ignored, refused)
      if (is_relaxed(work%scene%modes)) &          ! the result that is there may be of this scene after all
        call look_at_existing(outcome%file, work%scene, work%overwrite, existing, error, record=checksums_of(work))
      if (.not. allocated(error) .and. allocated(refused)) call move_alloc(refused, error)
    end if
    if (existing%is_there) call work%clear()
    if (existing%is_there) call outcome%set_found(work%scene, work%layout, existing)
    if (existing%is_there .or. allocated(error)) return
    call ask_for_memory(work, error)
    if (.not. allocated(error)) call work%begin(error)
    if (allocated(error)) return
    ! a run may have ended just now
    call look_at_existing(outcome%file, work%scene, work%overwrite, existing, error, record=checksums_of(work))
    if (existing%is_there) call outcome%set_found(work%scene, work%layout, existing)
    if (existing%is_there .or. allocated(error)) then
      call work%leave()
    else
      go = [1_i4]
    end if
  end subroutine look_first

  pure function checksums_of(work) result(text)
    !! The checksums of the files of a scene's record; empty where it has none.
    type(unfinished_work), intent(in) :: work
    character(:), allocatable :: text
    text = ''
    if (allocated(work%layout%record)) text = work%layout%record%checksums
  end function checksums_of

  subroutine ask_for_memory(work, error)
    !! Ask for the memory that a case takes, and give it back.
    !! **Errors**: `status_bad_file` where it is refused, before any work is done.
    type(unfinished_work), intent(in) :: work
    type(error_type), allocatable, intent(out) :: error
    integer(i1), allocatable :: room(:)
    integer :: stat
    allocate (room(working_bytes(work%scene, work%layout)), stat=stat)
    if (stat /= 0) call fail(error, status_bad_file, work%scene%file//': memory was refused: a case takes about '// &
                             bytes_text(working_bytes(work%scene, work%layout)))
  end subroutine ask_for_memory

  subroutine run_single(work, record, progress, outcome, error, supplement)
    !! Run the only case. After an error, or when it is stopped, nothing is left of it.
    type(unfinished_work), intent(inout) :: work          !! locked
    type(record_type), intent(inout) :: record            !! the scene's, used up; without samples where it has none
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    class(result_supplement), intent(inout), optional :: supplement
    type(case_result) :: result
    type(case_cache) :: cache
    type(stopwatch) :: watch
    integer(i1) :: none(0)
    logical :: whole
    call work%survey(0_i8, none, error)
    if (.not. allocated(error) .and. work%has_others()) call outcome%tell(work_taken_away)
    if (.not. allocated(error)) call work%remove_others(error)
    whole = .true.
    if (.not. allocated(error)) then
      call progress%begin(work%scene%name, 1_i8, 0_i8)
      if (allocated(work%scene%record)) call keep_record(work%scene, record, cache%record)
      call run_case(work%scene, work%layout, watch, progress, cache, result, whole)
      if (allocated(result%error)) call move_alloc(result%error, error)
      if (whole .and. .not. allocated(error)) &
        & call write_result(work, result, watch, progress, outcome, whole, error, supplement)
      call progress%end()
    end if
    if (.not. whole) call outcome%set_stopped(0_i8, 1_i8)
    call work%discard()
  end subroutine run_single

  subroutine write_result(work, result, watch, progress, outcome, whole, error, supplement)
    !! Write the file, give it its final name, and collect what there is to say of it.
    !! **Errors**: it cannot be written.
    type(unfinished_work), intent(in) :: work
    type(case_result), intent(inout) :: result
    type(stopwatch), intent(inout) :: watch
    class(progress_type), intent(inout) :: progress       !! may ask to stop
    type(outcome_type), intent(inout) :: outcome
    logical, intent(out) :: whole                         !! false where the monitor asked to stop
    type(error_type), allocatable, intent(inout) :: error
    class(result_supplement), intent(inout), optional :: supplement
    type(child_process) :: child
    type(result_file) :: file
    type(notes_type) :: notes
    type(string), allocatable :: texts(:)
    character(:), allocatable :: draft, report
    real(dp) :: began, added                              ! seconds of the supplement
    call forbid_lost(result, fields_of(work%layout))
    report = case_report(work%scene, result)
    call notes%add(1_i8, result%notes)
    call outcome%set_notes(notes%lines(work%layout%cases), work%layout, merge(0_i8, 1_i8, result%status == case_done))
    draft = work%new_draft()
    call child%begin()
    if (child%is_here()) then
      allocate (texts(0))
      call create_result(draft, work%scene, work%layout, file, error)
      if (.not. allocated(error)) call file%put_case(result, error)
      call watch%lap(stage_write)
      call file%finish(outcome%notes_text(), report, watch%seconds, error)
      call child%tell(texts, error)
    end if
    call child%hear(texts, whole, error, progress)
    if (.not. whole .or. allocated(error)) return
    began = wall_seconds()
    if (present(supplement)) call supplement%add(draft, progress, outcome%notes, report, whole, error)
    if (.not. whole .or. allocated(error)) return
    if (present(supplement)) call outcome%trust(supplement%trusted)
    added = wall_seconds() - began
    call work%publish(draft, error)
    call watch%lap(stage_write)
    call watch%rebook(stage_write, stage_spectrum, added)
    call watch%add_cpu(stage_write, child%seconds)
    if (.not. allocated(error)) call outcome%set_report(work%scene, work%layout, report, 0_i8, &
      stage_report(watch, sum(watch%seconds), 1, 1_i8))
  end subroutine write_result

end module bw_run_scene
