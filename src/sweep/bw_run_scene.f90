module bw_run_scene
  !! Run of a scene up to its finished file, reusing what exists. A scene without sweeps has one case; `bw_run_sweep`
  !! runs the cases of sweeps.
  use bw_case_result, only: case_done, case_motion, case_result
  use bw_case_tolerance, only: fix_tolerance
  use bw_error, only: error_type, fail, status_bad_file
  use bw_existing_result, only: existing_result, look_at_existing
  use bw_kinds, only: dp, i1, i4, i8
  use bw_load_courses, only: check_load_files
  use bw_modes_par, only: is_relaxed
  use bw_monitor, only: monitor_type, progress_type
  use bw_notes, only: notes_type
  use bw_one_case, only: case_cache, run_case
  use bw_outcome, only: outcome_type, unfinished_work_removed
  use bw_over_cases, only: over_cases
  use bw_process_group, only: process_group
  use bw_record, only: record_extent, record_type
  use bw_record_case, only: keep_record
  use bw_record_plan, only: plan_record
  use bw_report, only: case_report
  use bw_result_layout, only: layout_of
  use bw_result_supplement, only: result_supplement
  use bw_run_sweep, only: finish_draft, run_sweep
  use bw_scene, only: is_loaded, scene_type
  use bw_scene_summary, only: bytes_text, working_bytes
  use bw_stage_report, only: stage_report
  use bw_stopwatch, only: stage_words, stage_write, stopwatch
  use bw_unfinished_work, only: unfinished_work
  implicit none (type, external)
  private
  public :: run_scene

contains

  subroutine run_scene(scene, directory, overwrite, part, group, progress, outcome, error, supplement)
    !! Run all cases of a scene, write DIRECTORY/<scene>.nc, and report the outcome. Called by all processes; the leader
    !! gets the outcome.
    !! **Errors**: `status_bad_file` if a file cannot be read or written or belongs to another scene.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    integer, intent(in) :: part(2)              !! part and number of parts: only cases ≡ part(1) mod part(2) are run
    class(process_group), intent(inout) :: group
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    class(result_supplement), intent(inout), optional :: supplement    !! additions to the result
    type(unfinished_work) :: work
    type(record_extent), allocatable :: extents(:)
    type(record_type) :: record                 ! the last record read
    real(dp) :: nothing(0)
    logical :: is_sweep
    integer(i4), allocatable :: go(:)           ! its size is 1 if there is work to do
    type(case_motion), allocatable :: planned
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
    if (is_loaded(scene)) then
      call check_load_files(scene, work%layout%load_checksums, error)
      if (is_sweep) call group%collect(nothing, error)
      if (allocated(error)) return
    end if
    call work%plan(outcome%file, overwrite)
    call work%draft%plan(scene, work%layout, supplement)
    if (is_sweep) then
      work%part = part(1)
      work%parts = part(2)
    else if (part(1) > 1) then
      call outcome%set_part_without_case(scene, part(1), part(2))
      return
    end if
    allocate (go(0))
    if (group%leads()) call look_first(work, progress, outcome, go, planned, error)
    if (is_sweep) call group%share(go)
    if (size(go) == 0) return
    if (is_sweep) then
      call run_sweep(work, group, progress, outcome, error, supplement)
    else
      call run_single(work, record, planned, progress, outcome, error, supplement)
    end if
  end subroutine run_scene

  subroutine look_first(work, monitor, outcome, go, planned, error)
    !! Find out whether there is work to do and room for it; then take the lock, and remove drafts of other work.
    type(unfinished_work), intent(inout) :: work
    class(monitor_type), intent(inout) :: monitor
    type(outcome_type), intent(inout) :: outcome
    integer(i4), allocatable, intent(inout) :: go(:)
    type(case_motion), allocatable, intent(out) :: planned    !! plan of a single case, if its tolerance needs one
    type(error_type), allocatable, intent(out) :: error
    type(existing_result) :: existing
    type(error_type), allocatable :: refused
    integer :: ignored
    call look()
    if (.not. existing%is_there .and. .not. (allocated(error) .and. work%scene%modes%asked)) then
      call fix_tolerance(work%scene, monitor, ignored, refused, planned)
      if (is_relaxed(work%scene%modes)) then
        if (allocated(planned)) deallocate (planned)   ! so that a run of the resolved scene has the same plan
        call work%draft%plan(work%scene, work%layout)
        call look()                               ! the existing result may be of this scene after all
      end if
      if (.not. allocated(error) .and. allocated(refused)) call move_alloc(refused, error)
    end if
    if (existing%is_there) call work%clear()
    if (existing%is_there .or. allocated(error)) return
    call ask_for_memory(work, error)
    if (.not. allocated(error)) call work%begin(error)
    if (allocated(error)) return
    call look()                                 ! a run may have ended just now
    if (.not. (existing%is_there .or. allocated(error))) call work%remove(own=.false., others=.true., error=error)
    if (work%took_away) call outcome%tell(unfinished_work_removed)
    if (existing%is_there .or. allocated(error)) then
      call work%leave()
    else
      go = [1_i4]
    end if
  contains
    subroutine look()
      character(:), allocatable :: checksums
      checksums = ''
      if (allocated(work%layout%load_checksums)) checksums = work%layout%load_checksums
      if (allocated(work%layout%record)) checksums = work%layout%record%checksums
      call look_at_existing(outcome%file, work%scene, work%overwrite, existing, error, checksums=checksums)
      if (existing%is_there) call outcome%set_found(work%scene, work%layout, existing)
    end subroutine look
  end subroutine look_first

  subroutine ask_for_memory(work, error)
    !! Check that the memory of a case can be allocated, and release it.
    !! **Errors**: `status_bad_file` if it is refused, before any work is done.
    type(unfinished_work), intent(in) :: work
    type(error_type), allocatable, intent(out) :: error
    integer(i1), allocatable :: room(:)
    integer(i8) :: bytes
    integer :: stat
    bytes = working_bytes(work%scene, work%layout)
    allocate (room(bytes), stat=stat)
    if (stat /= 0) call fail(error, status_bad_file, work%scene%file//': not enough memory: a case takes about '// &
                             bytes_text(bytes))
  end subroutine ask_for_memory

  subroutine run_single(work, record, planned, progress, outcome, error, supplement)
    !! Run the only case. After an error or a stop no draft remains.
    type(unfinished_work), intent(inout) :: work          !! locked
    type(record_type), intent(inout) :: record            !! of the scene, consumed; without samples if it has none
    type(case_motion), allocatable, intent(inout) :: planned   !! up to its histories, consumed; unallocated: not planned
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    class(result_supplement), intent(inout), optional :: supplement
    type(case_result) :: result
    type(case_cache) :: cache
    type(over_cases) :: over                              ! empty
    type(stopwatch) :: watch
    type(notes_type) :: notes
    character(:), allocatable :: report
    logical :: whole
    whole = .true.
    call watch%start()
    call work%remove(own=.true., others=.false., error=error)
    if (.not. allocated(error)) call work%draft%create(work%draft_of(''), error)
    call watch%lap(stage_write)
    if (.not. allocated(error)) then
      call progress%begin(work%scene%name, 1_i8, 0_i8)
      if (allocated(work%scene%record)) call keep_record(work%scene, record, cache%record)
      call run_case(work%scene, work%layout, watch, progress, cache, result, whole, planned)
      if (allocated(result%error)) call move_alloc(result%error, error)
    end if
    if (whole .and. .not. allocated(error)) then
      call work%draft%put_case(1_i8, result)
      report = case_report(work%scene, result)
      call notes%add(1_i8, result%notes)
      call outcome%set_notes(notes%lines(0), work%layout, merge(0_i8, 1_i8, result%status == case_done))
      call work%draft%write_cases()
      call work%draft%file%flush(error)
      call work%draft%put_statuses([1], [result%status])
      call progress%cases_done(1_i8)
      call progress%enter(trim(stage_words(stage_write)))
      call finish_draft(work, report, watch, progress, outcome, whole, error, over, supplement)
    end if
    call progress%end()
    if (.not. whole) call outcome%set_stopped(0_i8, 1_i8)
    if (whole .and. .not. allocated(error)) call outcome%set_report(work%scene, work%layout, report, 0_i8, &
                                                                    stage_report(watch, sum(watch%seconds), 1, 1_i8))
    call work%draft%file%close()
    call work%discard()
  end subroutine run_single

end module bw_run_scene
