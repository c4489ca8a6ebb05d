module bw_run_scene
  !! A scene from its first case to its finished file: what is there already, what is left to do, and the report.
  use bw_kinds, only: i1, i8
  use bw_case_result, only: case_result, case_done
  use bw_error, only: error_type, fail, status_bad_file, status_done, status_not_trusted, status_stopped
  use bw_notes, only: notes_type
  use bw_one_case, only: run_case
  use bw_posix, only: file_exists, make_directory, remove_directory, remove_file, rename_file
  use bw_progress, only: progress_type
  use bw_report, only: case_heading, case_line, case_report, notes_report, stage_report
  use bw_result_file, only: result_file, create_result, reopen_result
  use bw_result_header, only: holds_scene
  use bw_result_layout, only: result_layout, layout_of
  use bw_scene, only: scene_type
  use bw_scene_summary, only: bytes_text, scene_heading, scene_summary, working_bytes
  use bw_scene_cases, only: case_positions, case_scene
  use bw_stopwatch, only: stopwatch, stage_write
  use bw_text, only: text_of
  use bw_text_builder, only: text_builder
  implicit none (type, external)
  private
  public :: run_scene

  integer, parameter :: shown_cases = 20      !! rows of a sweep in the report
  integer(i8), parameter :: save_every = 1000 !! cases between two saves to disk

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
    integer(i8) :: taken_over = 0             !! cases that an earlier run had finished
    integer :: shown = 0
    integer(i8) :: not_trusted = 0
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
    character(:), allocatable :: partial
    partial = directory//'/'//scene%name//'.partial'
    outcome%file = directory//'/'//scene%name//'.nc'
    call look_at_existing(scene, outcome, overwrite, error)
    if (allocated(error) .or. outcome%was_there) return
    call layout_of(scene, state%layout, error)
    if (.not. allocated(error)) call ask_for_memory(scene, state%layout, error)
    if (allocated(error)) return
    call open_partial(scene, partial, state, error)
    if (allocated(error)) return
    call run_cases(scene, progress, state, outcome, error)
    if (allocated(error)) then
      call abandon(state, partial)
    else if (outcome%status == status_stopped) then
      call leave_for_later(state, outcome, error)
    else
      call complete(scene, partial, state, outcome, error)
    end if
  end subroutine run_scene

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

  subroutine look_at_existing(scene, outcome, overwrite, error)
    !! A finished result of the same scene and version is left alone; another is an error unless it may be replaced.
    type(scene_type), intent(in) :: scene
    type(outcome_type), intent(inout) :: outcome
    logical, intent(in) :: overwrite
    type(error_type), allocatable, intent(out) :: error
    if (.not. file_exists(outcome%file)) return
    outcome%was_there = holds_scene(outcome%file, scene)
    if (outcome%was_there .or. overwrite) return
    call fail(error, status_bad_file, outcome%file//': is there already, of another scene or version; '// &
              '--overwrite replaces it')
  end subroutine look_at_existing

  subroutine open_partial(scene, partial, state, error)
    !! Go on with unfinished work of the same scene and version; anything else that lies there is discarded.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: partial
    type(run_state), intent(inout) :: state
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: path
    path = partial//'/result.nc'
    if (.not. make_directory(partial)) then
      call fail(error, status_bad_file, partial//': the directory cannot be made')
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
    call create_result(path, scene, state%layout, state%file, error)
    if (allocated(error)) call discard(partial)
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
    logical, allocatable :: finished(:)
    integer(i8) :: i
    call state%file%finished_cases(finished, error)
    if (allocated(error)) return
    state%taken_over = count(finished)
    call progress%begin(scene%name, size(finished, kind=i8), state%taken_over)
    do i = 1, size(finished, kind=i8)
      if (finished(i)) cycle
      call case_scene(scene, i, one, error)
      if (allocated(error)) return
      if (.not. progress%stop_requested()) call run_case(one, state%layout, state%watch, progress, result, error)
      if (allocated(error)) return
      if (progress%stop_requested()) then
        outcome%status = status_stopped
        exit
      end if
      call state%file%put_case(i, result, error)
      if (mod(i, save_every) == 0 .and. .not. allocated(error)) call state%file%save(error)
      if (allocated(error)) return
      call state%watch%lap(stage_write)
      call take_account(scene, i, result, state)
      call progress%case_done()
    end do
    call progress%end()
    outcome%report = state%report%text()
  end subroutine run_cases

  subroutine take_account(scene, i, result, state)
    !! What the report and the notes say of a case.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: i
    type(case_result), intent(in) :: result
    type(run_state), intent(inout) :: state
    if (result%status /= case_done) state%not_trusted = state%not_trusted + 1
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

  subroutine complete(scene, partial, state, outcome, error)
    !! Close the file and give it its final name.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: partial
    type(run_state), intent(inout) :: state
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(text_builder) :: report
    if (state%not_trusted > 0) outcome%status = status_not_trusted
    outcome%warnings = state%notes%lines(state%layout%cases)
    if (state%not_trusted > 0 .and. state%layout%cases > 0) outcome%warnings = outcome%warnings// &
      text_of(state%not_trusted)//' of '//text_of(state%layout%cases)//' cases hold numbers that cannot be trusted'// &
      new_line('a')
    call state%file%finish(trimmed(outcome%warnings), state%watch%seconds, error)
    if (.not. allocated(error)) then
      if (.not. rename_file(partial//'/result.nc', outcome%file)) then
        call fail(error, status_bad_file, outcome%file//': the finished result cannot be moved there')
      end if
    end if
    call discard(partial)
    if (allocated(error)) return
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
    logical, allocatable :: finished(:)
    call state%file%finished_cases(finished, error)
    if (allocated(error)) return
    call state%file%close()
    outcome%warnings = outcome%file//': stopped with '//text_of(count(finished))//' of '//text_of(size(finished))// &
      ' cases saved; the same command goes on from there'//new_line('a')
    outcome%report = ''
  end subroutine leave_for_later

  subroutine abandon(state, partial)
    !! After an error: a single case leaves nothing, a sweep keeps the cases it has.
    type(run_state), intent(inout) :: state
    character(*), intent(in) :: partial
    call state%file%close()
    if (state%layout%cases == 0) call discard(partial)
  end subroutine abandon

  subroutine discard(partial)
    character(*), intent(in) :: partial
    call remove_file(partial//'/result.nc')
    call remove_directory(partial)
  end subroutine discard

end module bw_run_scene
