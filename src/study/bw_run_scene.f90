module bw_run_scene
  !! A scene from its first case to its finished file: what is there already, what is left to do, and the report.
  use bw_kept_notes, only: keep_notes, take_kept_notes
  use bw_kinds, only: dp, i1, i4, i8
  use bw_netcdf, only: unwritten
  use bw_case_result, only: case_result, case_done
  use bw_error, only: error_type, fail, status_bad_file, status_done, status_not_trusted, status_stopped
  use bw_existing_result, only: look_at_existing
  use bw_notes, only: notes_type
  use bw_modes_par, only: by_tolerance
  use bw_one_case, only: plan_case, run_case
  use bw_posix, only: file_exists, lock_file, make_directory, remove_directory, remove_file, rename_file, &
    unlock_file
  use bw_progress, only: progress_type
  use bw_report, only: case_heading, case_line, case_report, notes_report, stage_report
  use bw_result_file, only: result_file, create_result, reopen_result
  use bw_result_header, only: holds_scene
  use bw_result_layout, only: result_layout, layout_of
  use bw_scene, only: scene_type
  use bw_scene_summary, only: bytes_text, scene_heading, scene_summary, working_bytes
  use bw_scene_cases, only: case_positions, case_scene
  use bw_stopwatch, only: stopwatch, stage_write, wall_seconds
  use bw_text, only: text_of
  use bw_text_builder, only: text_builder
  implicit none (type, external)
  private
  public :: run_scene

  integer, parameter :: shown_cases = 20      !! rows of a sweep in the report
  real(dp), parameter :: save_every = 5.0_dp  !! s between two saves to the disk
  character(*), parameter :: result_name = '/result.nc', notes_name = '/notes', lock_name = '/lock'

  type, public :: outcome_type
    !! How a scene ended.
    integer :: status = status_done           !! an exit status
    logical :: was_there = .false.            !! the finished result was there already
    character(:), allocatable :: file         !! the result
    character(:), allocatable :: report       !! what to print
    character(:), allocatable :: warnings     !! lines
  end type outcome_type

  type :: run_state
    !! A scene under way.
    type(result_layout) :: layout
    type(result_file) :: file
    type(stopwatch) :: watch
    type(text_builder) :: report
    type(notes_type) :: notes
    character(:), allocatable :: partial      !! directory of the unfinished work
    integer :: lock = -1                      !! on that directory
    integer(i8) :: taken_over = 0             !! cases that an earlier run had finished
    integer :: shown = 0
    real(dp) :: saved = 0.0_dp                !! when the file was last brought to the disk, s
  end type run_state

contains

  subroutine run_scene(scene, directory, overwrite, progress, outcome, error)
    !! Run all cases of a scene, write DIRECTORY/<scene>.nc, and say how it went.
    !! **Errors**: `status_bad_file` where a file cannot be read or written or is another scene's.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(run_state) :: state
    state%partial = directory//'/'//scene%name//'.partial'
    outcome%file = directory//'/'//scene%name//'.nc'
    call look_at_existing(outcome%file, scene, overwrite, outcome%was_there, error)
    if (allocated(error) .or. outcome%was_there) return
    state%layout = layout_of(scene)
    call refuse_out_of_reach(scene, error)
    if (.not. allocated(error)) call ask_for_memory(scene, state%layout, error)
    if (.not. allocated(error)) call open_partial(scene, state, error)
    if (allocated(error)) return
    call run_cases(scene, progress, state, outcome, error)
    if (allocated(error)) then
      call abandon(state)
    else if (outcome%status == status_stopped) then
      call leave_for_later(state, outcome, error)
    else
      call complete(scene, state, outcome, error)
    end if
    call unlock_file(state%lock)
  end subroutine run_scene

  subroutine refuse_out_of_reach(scene, error)
    !! A single case whose tolerance is out of reach is refused before anything is written; in a sweep such a case is
    !! recorded and the others go on.
    type(scene_type), intent(in) :: scene
    type(error_type), allocatable, intent(out) :: error
    integer :: ignored
    if (by_tolerance(scene%modes) .and. size(scene%sweeps) == 0) call plan_case(scene, ignored, error)
  end subroutine refuse_out_of_reach

  subroutine ask_for_memory(scene, layout, error)
    !! Memory that is refused is refused before any work is done.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(error_type), allocatable, intent(out) :: error
    integer(i1), allocatable :: room(:)
    integer :: stat
    allocate (room(working_bytes(layout)), stat=stat)
    if (stat /= 0) call fail(error, status_bad_file, scene%file//': memory was refused: a case takes about '// &
                             bytes_text(working_bytes(layout)))
  end subroutine ask_for_memory

  subroutine open_partial(scene, state, error)
    !! Go on with unfinished work of the same scene and version; anything else that lies there is discarded, unless
    !! another run is at work on it.
    type(scene_type), intent(in) :: scene
    type(run_state), intent(inout) :: state
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: path
    logical :: held
    path = state%partial//result_name
    if (.not. make_directory(state%partial)) then
      call fail(error, status_bad_file, state%partial//': the directory cannot be made')
      return
    end if
    call lock_file(state%partial//lock_name, state%lock, held)
    if (held) then
      call fail(error, status_bad_file, state%partial//': another run is at work on this scene')
      return
    end if
    if (file_exists(path)) then
      if (holds_scene(path, scene)) then
        call reopen_result(path, scene, state%layout, state%file, error)
        if (.not. allocated(error)) return
        deallocate (error)
      end if
      call remove_file(path)
    end if
    call remove_file(state%partial//notes_name)
    call create_result(path, scene, state%layout, state%file, error)
    if (allocated(error)) call discard(state)
  end subroutine open_partial

  subroutine run_cases(scene, progress, state, outcome, error)
    !! Every case that is not in the file yet, until done or stopped.
    type(scene_type), intent(in) :: scene
    class(progress_type), intent(inout) :: progress
    type(run_state), intent(inout) :: state
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(case_result) :: result
    type(scene_type) :: one
    integer(i4), allocatable :: status(:)
    logical :: whole
    integer(i8) :: i
    call state%file%case_states(status, error)
    if (allocated(error)) return
    state%taken_over = count(status /= unwritten)
    if (state%taken_over > 0) call take_kept_notes(state%partial//notes_name, status /= unwritten, state%notes)
    call progress%begin(scene%name, size(status, kind=i8), state%taken_over)
    state%saved = wall_seconds()
    do i = 1, size(status, kind=i8)
      if (status(i) /= unwritten) cycle
      whole = .not. progress%stop_requested()
      if (whole) then
        call case_scene(scene, i, one, error)
        if (allocated(error)) return
        call run_case(one, state%layout, state%watch, progress, result, whole)
      end if
      if (.not. whole) then
        outcome%status = status_stopped
        exit
      end if
      call save_case(i, result, state, error)
      if (allocated(error)) return
      call take_account(scene, i, result, state)
      call progress%case_done()
    end do
    call progress%end()
    outcome%report = state%report%text()
  end subroutine run_cases

  subroutine save_case(i, result, state, error)
    !! Put a case into the file, and every few seconds bring the file to the disk.
    integer(i8), intent(in) :: i
    type(case_result), intent(in) :: result
    type(run_state), intent(inout) :: state
    type(error_type), allocatable, intent(out) :: error
    if (state%layout%cases > 0) call keep_notes(state%partial//notes_name, i, result%notes)
    call state%file%put_case(i, result, error)
    if (allocated(error)) return
    if (wall_seconds() - state%saved > save_every) then
      call state%file%save(error)
      state%saved = wall_seconds()
    end if
    call state%watch%lap(stage_write)
  end subroutine save_case

  subroutine take_account(scene, i, result, state)
    !! What the report and the notes say of a case.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: i
    type(case_result), intent(in) :: result
    type(run_state), intent(inout) :: state
    call state%notes%add(i, result%notes)
    if (state%layout%cases == 0) then
      call state%report%append(case_report(result))
      return
    end if
    state%shown = state%shown + 1
    if (state%shown == 1) call state%report%append(new_line('a')//case_heading())
    if (state%shown > shown_cases) return
    call state%report%append(case_line(int(i), case_text(scene, i), result))
  end subroutine take_account

  function case_text(scene, i) result(text)
    !! The swept values of a case: 'name = value, …'.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: i
    character(:), allocatable :: text
    integer :: positions(size(scene%sweeps)), s
    positions = case_positions(scene, i)
    text = ''
    do s = 1, size(scene%sweeps)
      if (s > 1) text = text//', '
      text = text//scene%sweeps(s)%parameter//' = '//text_of(scene%sweeps(s)%values(positions(s)))
    end do
  end function case_text

  subroutine complete(scene, state, outcome, error)
    !! Close the file and give it its final name.
    type(scene_type), intent(in) :: scene
    type(run_state), intent(inout) :: state
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(text_builder) :: report
    integer(i4), allocatable :: status(:)
    integer :: not_trusted
    call state%file%case_states(status, error)
    if (allocated(error)) return
    not_trusted = count(status /= case_done)
    if (not_trusted > 0) outcome%status = status_not_trusted
    outcome%warnings = state%notes%lines(state%layout%cases)
    if (not_trusted > 0 .and. state%layout%cases > 0) outcome%warnings = outcome%warnings// &
      text_of(not_trusted)//' of '//text_of(state%layout%cases)//' cases hold numbers that cannot be trusted'// &
      new_line('a')
    call state%file%finish(trimmed(outcome%warnings), state%watch%seconds, error)
    if (allocated(error)) return
    if (.not. rename_file(state%partial//result_name, outcome%file)) then
      call fail(error, status_bad_file, outcome%file//': the finished result cannot be moved there; it is '// &
                state%partial//result_name)
      return
    end if
    call discard(state)
    call report%append(scene_heading(scene))
    call report%append(scene_summary(scene, state%layout))
    call report%append(outcome%report)
    if (state%shown > shown_cases) call report%append_line('     ...   '//text_of(state%layout%cases)//' cases in all')
    if (state%taken_over > 0) call report%append_line('  '//text_of(state%taken_over)// &
      ' cases were taken over from an earlier run')
    call report%append_line('')
    call report%append(notes_report(trimmed(outcome%warnings)))
    call report%append(stage_report(state%watch%seconds))
    call report%append_line('  result     '//outcome%file)
    outcome%report = report%text()
  end subroutine complete

  pure function trimmed(lines) result(text)
    !! Without the last line's end.
    character(*), intent(in) :: lines
    character(:), allocatable :: text
    text = lines
    if (len(lines) > 0) text = lines(:len(lines) - 1)
  end function trimmed

  subroutine leave_for_later(state, outcome, error)
    !! Save what is finished; the same command goes on from there.
    type(run_state), intent(inout) :: state
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    integer(i4), allocatable :: status(:)
    call state%file%case_states(status, error)
    if (allocated(error)) return
    call state%file%close()
    outcome%warnings = outcome%file//': stopped with '//text_of(count(status /= unwritten))//' of '// &
      text_of(size(status))// &
      ' cases saved; the same command goes on from there'//new_line('a')
    outcome%report = ''
  end subroutine leave_for_later

  subroutine abandon(state)
    !! After an error: a single case leaves nothing, a sweep keeps the cases it has.
    type(run_state), intent(inout) :: state
    call state%file%close()
    if (state%layout%cases == 0) call discard(state)
  end subroutine abandon

  subroutine discard(state)
    !! Take the unfinished work away.
    type(run_state), intent(in) :: state
    call remove_file(state%partial//result_name)
    call remove_file(state%partial//notes_name)
    call remove_file(state%partial//lock_name)
    call remove_directory(state%partial)
  end subroutine discard

end module bw_run_scene
