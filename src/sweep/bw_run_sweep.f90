module bw_run_sweep
  !! A sweep: its cases are shared by all processes of a group, each of which puts its own into the draft of its host. A
  !! process that finds all cases done finishes the file.
  use bw_case_result, only: case_done
  use bw_error, only: error_type, status_done
  use bw_files, only: look_at, path_state
  use bw_kinds, only: dp, i1, i4, i8
  use bw_monitor, only: progress_type
  use bw_notes, only: notes_type
  use bw_outcome, only: outcome_type
  use bw_pooled_table, only: pooled_table
  use bw_process_group, only: process_group
  use bw_repeat_cases, only: pooled_cases
  use bw_over_cases, only: over_cases, quantiles_of_cases
  use bw_quantile_table, only: quantile_table
  use bw_result_draft, only: not_done
  use bw_result_layout, only: has
  use bw_result_supplement, only: result_supplement
  use bw_screen, only: details
  use bw_stage_report, only: stage_report
  use bw_stopwatch, only: stage_spectrum, stage_write, stopwatch, wall_seconds
  use bw_sweep_table, only: sweep_table
  use bw_text, only: string, text_of
  use bw_unfinished_work, only: unfinished_work
  use bw_worker, only: worker_type
  implicit none (type, external)
  private
  public :: finish_draft, run_sweep

contains

  subroutine run_sweep(work, group, progress, outcome, error, supplement)
    !! Run the remaining cases, and make the result. Called by all processes; the leader, which holds the lock, gets the
    !! outcome, and an error if any has one.
    type(unfinished_work), intent(inout) :: work
    class(process_group), intent(inout), target :: group
    class(progress_type), intent(inout), target :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    class(result_supplement), intent(inout), optional :: supplement    !! additions to the result
    type(worker_type) :: worker
    type(string), allocatable :: hosts(:)
    integer(i4), allocatable :: left(:), owner(:)      ! remaining cases; letters of the host of the first draft
    type(string) :: table                              ! of cases, to be printed; allocated if the result is in its place
    real(dp), allocatable :: totals(:)
    real(dp) :: began, nothing(0)
    integer(i8) :: before, done                        ! cases done earlier; cases done now
    call group%hosts(hosts)
    if (group%leads()) call take_up(work, hosts, left, owner, before, error)
    call group%share(owner)
    if (size(owner) == 0) return
    call group%share(left)
    work%owner = transfer(achar(owner), repeat(' ', size(owner)))
    began = wall_seconds()
    call work%open_draft(error)
    call group%collect(nothing, error)
    if (.not. allocated(error)) then
      call group%begin()
      worker%scene = work%scene
      if (group%leads()) call progress%begin(work%scene%name, size(left) + before, before)
      call worker%run_cases(work%draft, left, group, progress, done, error)
      totals = [worker%watch%totals(), real(done, dp)]
      call group%collect(totals, error)
      call worker%watch%set_totals(totals(:size(totals) - 1))
    end if
    if (group%leads() .and. .not. allocated(error)) call work%draft%file%flush(error)
    call work%draft%file%close()
    if (.not. group%leads()) return
    call conclude(work, progress, worker%watch, table, outcome, error, supplement)
    call progress%end()
    if (.not. allocated(table%text)) return
    before = work%layout%cases - nint(totals(size(totals)), i8)        ! including other parts
    call outcome%set_report(work%scene, work%layout, table%text, before, &
                            stage_report(worker%watch, wall_seconds() - began, group%processes, size(left, kind=i8)))
  end subroutine run_sweep

  subroutine take_up(work, hosts, left, owner, before, error)
    !! Find the remaining cases, and create the drafts: the leader's first step.
    !! **Errors**: a draft cannot be read or made, or another process works on the same part.
    type(unfinished_work), intent(inout) :: work
    type(string), intent(in) :: hosts(:)
    integer(i4), allocatable, intent(out) :: left(:), owner(:)    !! `owner` is empty after an error
    integer(i8), intent(out) :: before                !! finished cases of this part
    type(error_type), allocatable, intent(out) :: error
    integer(i1), allocatable :: statuses(:)
    integer :: i, n
    allocate (owner(0), left(0))
    before = 0
    call work%survey(statuses, error)
    if (.not. allocated(error)) call work%provide(hosts, error)
    if (work%parts > 1) call work%begin_part(error)
    if (allocated(error)) call work%leave()
    if (allocated(error)) return
    owner = [(ichar(work%owner(i:i)), i=1, len(work%owner))]
    before = count(statuses(work%part::work%parts) /= not_done)
    deallocate (left)
    allocate (left(count(statuses(work%part::work%parts) == not_done)))
    n = 0
    do i = work%part, work%layout%cases, work%parts
      if (statuses(i) /= not_done) cycle
      n = n + 1
      left(n) = i
    end do
  end subroutine take_up

  subroutine conclude(work, progress, watch, table, outcome, error, supplement)
    !! Finish the file if all cases are done; else leave the drafts for a later run, and report it.
    type(unfinished_work), intent(inout) :: work      !! no draft of it is open
    class(progress_type), intent(inout) :: progress   !! may request a stop
    type(stopwatch), intent(inout) :: watch
    type(string), intent(out) :: table                !! of cases, to be printed; only if the result is in its place
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    class(result_supplement), intent(inout), optional :: supplement
    type(error_type), allocatable :: unread           ! a draft cannot be read
    integer(i1), allocatable :: statuses(:)
    logical :: is_busy, whole                         ! others are at work; no stop was requested
    is_busy = .false.
    if (work%parts > 1) call work%begin_end(is_busy, error)
    call work%survey(statuses, unread)
    if (.not. allocated(error)) call move_alloc(unread, error)
    if (work%parts > 1) call work%end_part(is_busy, error)
    whole = .true.
    if (all(statuses /= not_done) .and. .not. (allocated(error) .or. is_busy)) &
      & call assemble(work, statuses, progress, watch, table, outcome, whole, error, supplement)
    associate (own => statuses(work%part::work%parts), saved => count(statuses /= not_done, kind=i8))
      if (allocated(error)) then
        error%message = error%message//new_line('a')//saved_text(work, saved)
      else if (allocated(table%text)) then
        if (work%parts > 1 .and. all(own == case_done)) outcome%status = status_done      ! failures of others do not count
        if (present(supplement)) call outcome%trust(supplement%trusted)
      else if (work%parts > 1 .and. all(own /= not_done) .and. whole) then
        call outcome%set_part(work%scene, work%part, work%parts, statuses)
      else
        call outcome%set_stopped(saved, int(work%layout%cases, i8))
      end if
    end associate
    call work%draft%file%close()
    if (allocated(table%text)) call work%discard()
    call work%leave()
  end subroutine conclude

  function saved_text(work, saved) result(text)
    !! Report what remains after an error, and how to continue.
    type(unfinished_work), intent(in) :: work
    integer(i8), intent(in) :: saved                  !! cases
    character(:), allocatable :: text
    type(path_state) :: state
    integer :: ignored
    ignored = look_at(work%result, state)
    text = work%result//': '//text_of(saved)//' of '//text_of(work%layout%cases)//' cases are saved; the same command'
    if (saved == 0) then
      text = text//' begins anew'
    else if (.not. work%overwrite .and. state%kind > 0) then
      text = text//' with --overwrite goes on from there'
    else
      text = text//' goes on from there'
    end if
  end function saved_text

  subroutine assemble(work, statuses, progress, watch, table, outcome, whole, error, supplement)
    !! Make the result of all cases, and give it its final name.
    !! **Errors**: it cannot be written, or drafts cannot be read.
    type(unfinished_work), intent(inout) :: work
    integer(i1), intent(in) :: statuses(:)            !! of all cases
    class(progress_type), intent(inout) :: progress   !! may request a stop
    type(stopwatch), intent(inout) :: watch
    type(string), intent(out) :: table                !! of cases, to be printed; only if the result is in its place
    type(outcome_type), intent(inout) :: outcome
    logical, intent(out) :: whole                     !! false if the monitor asked to stop
    type(error_type), allocatable, intent(inout) :: error
    class(result_supplement), intent(inout), optional :: supplement
    type(over_cases) :: over
    character(:), allocatable :: report
    call watch%start()
    call work%merge(error)
    whole = .true.
    if (allocated(error)) return
    report = sweep_table(work%draft, statuses)
    if (has(work%layout, 'pooled')) then
      over%pooled = pooled_cases(work%draft)
      if (size(over%pooled%count) > 0) report = details(report)
      report = report//pooled_table(over%pooled, size(statuses), work%scene%spectrum%confidence, &
                                       work%layout%record%sensors, work%layout%record%frequencies)
    end if
    if (has(work%layout, 'quantile')) then
      call quantiles_of_cases(work%draft, over%quantiles)
      report = report//quantile_table(work%draft, over%quantiles)
    end if
    call outcome%set_notes(notes_of(work), work%layout, count(statuses /= case_done, kind=i8))
    call finish_draft(work, report, watch, progress, outcome, whole, error, over, supplement)
    if (whole .and. .not. allocated(error)) call move_alloc(report, table%text)
  end subroutine assemble

  function notes_of(work) result(lines)
    !! Join the notes of all cases.
    type(unfinished_work), intent(inout) :: work
    character(:), allocatable :: lines
    type(notes_type) :: notes
    type(string), allocatable :: texts(:)
    integer, allocatable :: cases(:)
    integer :: i
    call work%draft%find_notes(cases)
    do i = 1, size(cases)
      call work%draft%get_notes(int(cases(i), i8), texts)
      call notes%add(int(cases(i), i8), texts)
    end do
    lines = notes%lines(work%layout%cases)
  end function notes_of

  subroutine finish_draft(work, report, watch, progress, outcome, whole, error, over, supplement)
    !! Complete the first draft, whose cases are all done, and give it its final name.
    !! **Errors**: that is refused, or an earlier operation was.
    type(unfinished_work), intent(inout) :: work      !! with that draft open
    character(:), allocatable, intent(inout) :: report
    type(stopwatch), intent(inout) :: watch
    class(progress_type), intent(inout) :: progress   !! may request a stop
    type(outcome_type), intent(inout) :: outcome
    logical, intent(out) :: whole                     !! false if the monitor asked to stop
    type(error_type), allocatable, intent(inout) :: error
    type(over_cases), intent(in) :: over              !! empty of a single case
    class(result_supplement), intent(inout), optional :: supplement
    real(dp) :: began, added                          ! seconds of the supplement
    whole = .true.
    began = wall_seconds()
    if (present(supplement) .and. .not. allocated(error)) &
      & call supplement%add(work%draft, progress, outcome%notes, report, whole, error)
    added = wall_seconds() - began
    if (allocated(error) .or. .not. whole) return
    if (present(supplement)) call outcome%trust(supplement%trusted)
    call watch%lap(stage_write)
    call watch%rebook(stage_write, stage_spectrum, added)
    call work%draft%finish(outcome%notes_text(), report, watch%seconds, over, error)
    call work%publish(error)
    call watch%lap(stage_write)
  end subroutine finish_draft

end module bw_run_sweep
