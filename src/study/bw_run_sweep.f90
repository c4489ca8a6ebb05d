module bw_run_sweep
  !! A sweep: its cases are shared by all processes of a crew, and the leader puts the result together.
  use bw_case_keeper, only: case_keeper
  use bw_case_loop, only: run_cases
  use bw_case_queue, only: case_queue, queue_of
  use bw_crew, only: crew_type
  use bw_error, only: error_type, fail, status_bad_file
  use bw_gathering, only: gathering_type
  use bw_kinds, only: dp, i1, i8
  use bw_outcome, only: outcome_type, work_taken_away
  use bw_posix, only: rename_file
  use bw_progress, only: progress_type
  use bw_result_body, only: result_body
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_stage_table, only: stage_table
  use bw_stopwatch, only: stage_write, stopwatch, wall_seconds
  use bw_sweep_places, only: settle_places
  use bw_text, only: text_of
  use bw_unfinished, only: unfinished_work
  implicit none (type, external)
  private
  public :: run_sweep

  type :: sweep_state
    !! A sweep under way, as its leader knows it.
    integer(i8) :: cases = 0
    integer(i8) :: taken_over = 0             !! cases that an earlier run had finished
    integer(i8) :: finished = 0               !! all that are finished
    logical :: discarded = .false.            !! work of another scene or version lay there
    integer(i8) :: damaged = 0                !! cases that an earlier run had finished and that did not last
    real(dp) :: began = 0.0_dp                !! when its first case was handed out, s
    type(case_queue) :: queue
  end type sweep_state

contains

  subroutine run_sweep(scene, layout, unfinished, crew, progress, outcome, error)
    !! Called by all processes; the leader gets the outcome, and an error if any has one.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(inout) :: unfinished
    class(crew_type), intent(inout) :: crew
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(sweep_state) :: state
    type(stopwatch) :: watch
    type(result_body) :: body
    type(gathering_type), allocatable :: gathering    ! of the leader
    integer :: number
    number = 0
    if (crew%leads()) then
      allocate (gathering)
      call take_up(scene, layout, unfinished, crew%processes, body, state, gathering, number, error)
      if (state%discarded) call outcome%remark(work_taken_away)
      if (state%damaged > 0) call outcome%remark(text_of(state%damaged)// &
        ' finished cases of an earlier run were not as it had left them and are done again')
    end if
    call crew%agree(number)
    if (number == 0 .and. crew%leads()) then
      call body%close()
      call unfinished%release()
    end if
    if (number == 0) return
    if (crew%leads()) call progress%begin(scene%name, state%cases, state%taken_over)
    call work(scene, layout, unfinished, number + crew%number, body, crew, progress, state, watch, error, gathering)
    if (.not. crew%leads()) call body%close()
    if (.not. crew%leads()) return
    call progress%end()
    if (.not. allocated(error) .and. state%finished == state%cases) then
      call complete(scene, layout, unfinished, state, crew%processes, watch, gathering, outcome, error)
    else
      call leave_for_later(unfinished, state, gathering, outcome, error)
    end if
    call body%close()
    if (allocated(error)) call tell_what_is_saved(unfinished, state%cases, outcome%file, error)
    call unfinished%release()
  end subroutine run_sweep

  subroutine leave_for_later(unfinished, state, gathering, outcome, error)
    !! A run that was stopped, or has an error.
    !! **Errors**: finished cases are not where they were put.
    type(unfinished_work), intent(in) :: unfinished
    type(sweep_state), intent(in) :: state
    type(gathering_type), intent(inout) :: gathering
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    call gathering%end()
    call gathering%assembly%abandon(unfinished)
    if (allocated(error)) return
    if (unfinished%saved(state%cases) < state%finished) then
      call fail(error, status_bad_file, unfinished%directory//': finished cases are gone from there')
    else
      call outcome%set_stopped(state%finished, state%cases)
    end if
  end subroutine leave_for_later

  subroutine tell_what_is_saved(unfinished, cases, file, error)
    !! After an error: what the same command will find.
    type(unfinished_work), intent(in) :: unfinished
    integer(i8), intent(in) :: cases
    character(*), intent(in) :: file          !! the result
    type(error_type), intent(inout) :: error
    integer(i8) :: saved
    saved = unfinished%saved(cases)
    error%message = error%message//new_line('a')//file//': '//text_of(saved)//' of '//text_of(cases)//' cases are saved; '
    if (saved > 0) error%message = error%message//'the same command goes on from there'
    if (saved == 0) error%message = error%message//'the same command begins anew'
  end subroutine tell_what_is_saved

  subroutine take_up(scene, layout, unfinished, processes, body, state, gathering, number, error)
    !! What is finished already, what is left to do, the number of the first new journal, and a result without cases.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(inout) :: unfinished
    integer, intent(in) :: processes
    type(result_body), intent(inout) :: body
    type(sweep_state), intent(inout) :: state
    type(gathering_type), intent(inout) :: gathering
    integer, intent(inout) :: number
    type(error_type), allocatable, intent(out) :: error
    integer(i1), allocatable :: done(:)
    call unfinished%begin(error)
    if (allocated(error)) return
    call settle_places(scene, layout, unfinished, body, error)
    if (allocated(error)) return
    allocate (done(layout%cases), source=0_i1)
    call unfinished%survey(done, body, state%discarded, state%damaged, error)
    if (allocated(error)) return
    call gathering%assembly%begin(scene, layout, unfinished, body, error)
    if (allocated(error)) return
    number = unfinished%next_number()
    call gathering%begin(unfinished, number, processes)
    state%queue = queue_of(done)
    state%cases = layout%cases
    state%taken_over = state%cases - state%queue%left
    state%finished = state%taken_over
    state%began = wall_seconds()
  end subroutine take_up

  subroutine work(scene, layout, unfinished, number, body, crew, progress, state, watch, error, gathering)
    !! All cases that are left, unless they are stopped.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(in) :: unfinished
    integer, intent(in) :: number             !! of this process's journal
    type(result_body), intent(inout) :: body  !! the leader has settled its own
    class(crew_type), intent(inout) :: crew
    class(progress_type), intent(inout) :: progress
    type(sweep_state), intent(inout) :: state
    type(stopwatch), intent(inout) :: watch
    type(error_type), allocatable, intent(out) :: error
    type(gathering_type), intent(inout), optional :: gathering
    type(case_keeper) :: keeper
    integer(i8) :: done
    real(dp), allocatable :: totals(:)
    if (.not. crew%leads()) call find_places(unfinished, layout, crew, body)
    call keeper%begin(unfinished%journal(number), unfinished%work, body, crew%near_leader)
    call crew%begin(state%queue)
    call run_cases(scene, layout, keeper, crew, progress, watch, done, error, gathering)
    state%finished = state%finished + done
    totals = watch%totals()
    call crew%end(totals, error)
    call watch%set_totals(totals)
    call crew%attend(done)                    ! what others told last
    state%finished = state%finished + done
  end subroutine work

  subroutine find_places(unfinished, layout, crew, body)
    !! Another process finds what the leader has settled. One on another machine does not: what several machines write into one
    !! file is not safe on every file system. Who has no places keeps whole cases in its journal.
    type(unfinished_work), intent(in) :: unfinished
    type(result_layout), intent(in) :: layout
    class(crew_type), intent(in) :: crew
    type(result_body), intent(inout) :: body
    type(error_type), allocatable :: refused
    call body%plan(layout)
    if (.not. crew%near_leader .or. .not. body%has_long()) return
    call body%find(unfinished%head_path())
    if (body%known()) call body%open(unfinished%result_path(), refused)
    if (allocated(refused)) call body%forget()
  end subroutine find_places

  subroutine complete(scene, layout, unfinished, state, processes, watch, gathering, outcome, error)
    !! The result under its final name.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(inout) :: unfinished
    type(sweep_state), intent(in) :: state
    integer, intent(in) :: processes
    type(stopwatch), intent(inout) :: watch
    type(gathering_type), intent(inout) :: gathering
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    call watch%start()
    call gathering%complete(unfinished, error)
    if (allocated(error)) call gathering%assembly%abandon(unfinished)
    if (allocated(error)) return
    call outcome%set_notes(gathering%assembly%notes, layout, gathering%assembly%not_trusted)
    call watch%lap(stage_write)
    call gathering%assembly%finish(unfinished, outcome%notes_text(), watch%seconds, error)
    if (allocated(error)) return
    if (.not. rename_file(unfinished%result_path(), outcome%file)) then
      call fail(error, status_bad_file, outcome%file//': the finished result cannot be moved there from '// &
                unfinished%result_path())
      return
    end if
    call unfinished%discard()
    call outcome%set_report(scene, layout, gathering%assembly%table%text(), state%taken_over, &
      stage_table(watch, wall_seconds() - state%began, processes, state%cases - state%taken_over))
  end subroutine complete

end module bw_run_sweep
