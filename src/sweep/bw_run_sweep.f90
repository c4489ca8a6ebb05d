module bw_run_sweep
  !! A sweep: its cases are shared by all processes of a group, each of which keeps its own in a journal; in the end the leader
  !! makes the result of the journals.
  use bw_assembly, only: assembly_type
  use bw_case_fields, only: case_length, fields_of
  use bw_child_process, only: child_process
  use bw_descriptors, only: flush_path
  use bw_error, only: error_type
  use bw_file_lock, only: unique_name
  use bw_files, only: cannot_be_written, flush_directory, look_at, path_state
  use bw_kinds, only: dp, i1, i4, i8
  use bw_monitor, only: progress_type
  use bw_outcome, only: outcome_type, work_taken_away
  use bw_process_group, only: process_group
  use bw_result_supplement, only: result_supplement
  use bw_stage_report, only: stage_report
  use bw_stopwatch, only: stage_spectrum, stage_write, stopwatch, wall_seconds
  use bw_text, only: append, string, text_of
  use bw_unfinished_work, only: journal_suffix, unfinished_work
  use bw_worker, only: worker_type
  implicit none (type, external)
  private
  public :: run_sweep

contains

  subroutine run_sweep(work, group, progress, outcome, error, supplement)
    !! Run the cases that are left, and make the result. Called by all processes; the leader, which has the lock of the work,
    !! gets the outcome, and an error if any has one.
    type(unfinished_work), intent(inout) :: work
    class(process_group), intent(inout), target :: group
    class(progress_type), intent(inout), target :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    class(result_supplement), intent(inout), optional :: supplement    !! what else belongs into the result
    type(worker_type) :: worker
    integer(i4), allocatable :: left(:), run(:)        ! cases that are to be done; letters of a name that no other run has
    real(dp), allocatable :: totals(:)
    character(:), allocatable :: table
    real(dp) :: began
    integer(i8) :: cases, saved, done                  ! in all; by an earlier run; now
    if (group%leads()) call take_up(work, progress, left, run, outcome, error)
    call group%share(run)
    if (size(run) == 0) return
    call group%share(left)
    call group%begin()
    began = wall_seconds()
    worker%scene = work%scene
    worker%layout = work%layout
    worker%journal%path = journal_path(work, run, group%number)
    worker%journal%work = work%identity
    cases = work%layout%cases
    saved = cases - size(left)
    if (group%leads()) call progress%begin(work%scene%name, cases, saved)
    call worker%run_cases(left, group, progress, done, error)
    totals = [worker%watch%totals(), real(done, dp)]
    call group%collect(totals, error)
    if (.not. group%leads()) return
    call worker%watch%set_totals(totals(:size(totals) - 1))
    done = nint(totals(size(totals)), i8)
    call add_journals(work, run, group%processes)
    if (.not. allocated(error) .and. saved + done == cases) &
      & call assemble(work, progress, worker%watch, table, outcome, error, supplement)
    call progress%end()
    if (allocated(table)) then
      call outcome%set_report(work%scene, work%layout, table, saved, &
                              stage_report(worker%watch, wall_seconds() - began, group%processes, size(left, kind=i8)))
      call work%discard()
    else
      call leave_for_later(work, saved + done, outcome, error)
    end if
  end subroutine run_sweep

  subroutine take_up(work, progress, left, run, outcome, error)
    !! Find out what is left to do of unfinished work: the first step of the leader.
    !! **Errors**: a journal cannot be read, or work of another scene or version not be taken away.
    type(unfinished_work), intent(inout) :: work
    class(progress_type), intent(inout) :: progress   !! may ask to stop
    integer(i4), allocatable, intent(out) :: left(:), run(:)    !! `run` is empty after an error
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    integer(i1), allocatable :: done(:)
    character(:), allocatable :: name
    integer :: i, n
    allocate (done(work%layout%cases), source=0_i1)
    allocate (run(0))
    call work%survey(case_length(fields_of(work%layout)), done, error, progress)
    if (.not. allocated(error) .and. work%has_others()) call outcome%tell(work_taken_away)
    if (.not. allocated(error)) call work%remove_others(error)
    if (work%damaged > 0) call outcome%tell('journals of an earlier run were '// &
      'not as it had left them in '//text_of(work%damaged)//' places; the finished cases there are done again')
    if (allocated(error)) then
      call work%leave()
      return
    end if
    name = unique_name()
    run = [(ichar(name(i:i)), i=1, len(name))]
    allocate (left(count(done == 0)))
    n = 0
    do i = 1, work%layout%cases
      if (done(i) /= 0) cycle
      n = n + 1
      left(n) = i
    end do
  end subroutine take_up

  pure function journal_path(work, run, number) result(path)
    !! The path of the journal of one process of a run.
    class(unfinished_work), intent(in) :: work
    integer(i4), intent(in) :: run(:)         !! letters of the run's name
    integer, intent(in) :: number             !! of the process
    character(:), allocatable :: path
    character(size(run)) :: name
    integer :: i
    do i = 1, size(run)
      name(i:i) = achar(run(i))
    end do
    path = work%path//'/'//name//'-'//text_of(number)//journal_suffix
  end function journal_path

  subroutine add_journals(work, run, processes)
    !! Add the journals of this run to those that were there. They are asked for by name: a list of a directory that other
    !! machines write to may be old.
    type(unfinished_work), intent(inout) :: work
    integer(i4), intent(in) :: run(:)
    integer, intent(in) :: processes
    type(path_state) :: state
    integer :: number, ignored
    do number = 0, processes - 1
      ignored = look_at(journal_path(work, run, number), state)
      if (state%kind > 0) call append(work%own, journal_path(work, run, number))
    end do
  end subroutine add_journals

  subroutine assemble(work, progress, watch, table, outcome, error, supplement)
    !! Make the result of the journals, and give it its final name.
    !! **Errors**: it cannot be written, or journals not be read.
    type(unfinished_work), intent(in) :: work
    class(progress_type), intent(inout) :: progress   !! may ask to stop
    type(stopwatch), intent(inout) :: watch
    character(:), allocatable, intent(out) :: table   !! of cases, to be printed; only of a result that is in its place
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    class(result_supplement), intent(inout), optional :: supplement
    type(child_process) :: child
    type(string), allocatable :: texts(:)
    character(:), allocatable :: draft
    real(dp) :: began, added                          ! seconds of the supplement
    integer(i8) :: not_trusted
    logical :: whole
    draft = work%new_draft()
    call watch%start()
    call child%begin()
    if (child%is_here()) then
      call write_result(draft, work, watch, texts, error)
      call child%tell(texts, error)
    end if
    call child%hear(texts, whole, error, progress)
    if (allocated(error) .or. .not. whole) return
    read (texts(3)%text, *) not_trusted
    call outcome%set_notes(texts(1)%text, work%layout, not_trusted)
    began = wall_seconds()
    if (present(supplement)) call supplement%add(draft, progress, outcome%notes, texts(2)%text, whole, error)
    if (allocated(error) .or. .not. whole) return
    if (present(supplement)) call outcome%trust(supplement%trusted)
    added = wall_seconds() - began
    call work%publish(draft, error)
    call watch%lap(stage_write)
    call watch%rebook(stage_write, stage_spectrum, added)
    call watch%add_cpu(stage_write, child%seconds)
    if (.not. allocated(error)) table = texts(2)%text
  end subroutine assemble

  subroutine write_result(draft, work, watch, texts, error)
    !! Write the whole file; `texts` are the notes, the table of cases, and how many of them cannot be trusted.
    character(*), intent(in) :: draft
    type(unfinished_work), intent(in) :: work
    type(stopwatch), intent(inout) :: watch
    type(string), allocatable, intent(out) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    type(assembly_type) :: assembly
    type(outcome_type) :: outcome
    integer :: i
    call assembly%begin(draft, work%scene, work%layout, error)
    do i = 1, size(work%own)
      if (.not. allocated(error)) call assembly%take_journal(work%own(i)%text, work%sum_of_identity(), error)
    end do
    call outcome%set_notes(assembly%notes%lines(work%layout%cases), work%layout, assembly%not_trusted)
    call watch%lap(stage_write)
    call assembly%finish(outcome%notes_text(), watch%seconds, error)
    call append(texts, assembly%notes%lines(work%layout%cases))
    call append(texts, assembly%report)
    call append(texts, text_of(assembly%not_trusted))
  end subroutine write_result

  subroutine leave_for_later(work, done, outcome, error)
    !! After an error, or when the run was stopped, leave the work so that the same command goes on from there, and say so.
    type(unfinished_work), intent(inout) :: work
    integer(i8), intent(in) :: done           !! cases that are finished
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    type(error_type), allocatable :: unreadable
    integer(i1), allocatable :: found(:)
    character(:), allocatable :: text
    call flush_journals(work, error)
    if (allocated(error)) then
      allocate (found(work%layout%cases), source=0_i1)
      call work%survey(case_length(fields_of(work%layout)), found, unreadable)
      text = outcome%file//': '//text_of(count(found /= 0))//' of '//text_of(work%layout%cases)//' cases are saved; '
      if (any(found /= 0)) text = text//'the same command'//in_the_way(work)//' goes on from there'
      if (all(found == 0)) text = text//'the same command begins anew'
      if (allocated(unreadable)) text = unreadable%message
      error%message = error%message//new_line('a')//text
    else
      call outcome%set_stopped(done, int(work%layout%cases, i8))
    end if
    call work%leave()
  end subroutine leave_for_later

  function in_the_way(work) result(option)
    !! The option that the command needs beside its own, as somebody else's result lies where the work's is to be.
    type(unfinished_work), intent(in) :: work
    character(:), allocatable :: option
    type(path_state) :: state
    option = ''
    if (work%overwrite) return
    if (look_at(work%result, state) == 0 .and. state%kind > 0) option = ' with --overwrite'
  end function in_the_way

  subroutine flush_journals(work, error)
    !! Flush the journals onto the disk: what is left for later is to outlive the machine.
    type(unfinished_work), intent(in) :: work
    type(error_type), allocatable, intent(inout) :: error
    integer :: problem, i
    do i = 1, size(work%own)
      problem = flush_path(work%own(i)%text)
      if (problem /= 0) call cannot_be_written(error, work%own(i)%text, problem)
    end do
    problem = flush_directory(work%path)
    if (problem /= 0) call cannot_be_written(error, work%path, problem)
  end subroutine flush_journals

end module bw_run_sweep
