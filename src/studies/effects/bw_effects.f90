module bw_effects
  !! The influence and cost of each effect on a scene: the scene run with it and without it.
  use bw_kinds, only: dp, i8
  use bw_case_rows, only: values_of
  use bw_case_notes, only: why_untrusted
  use bw_case_result, only: case_done, case_result
  use bw_effect_list, only: compare_frequencies, compared_case, effect_list
  use bw_effect_pairs, only: compared_scenes, pairs_of
  use bw_effect_report, only: effect_report, effect_values
  use bw_effect_table, only: in_words
  use bw_error, only: error_type, status_not_trusted
  use bw_hint, only: compared_modes
  use bw_missing, only: missing
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: progress_type
  use bw_outcome, only: outcome_type
  use bw_scene, only: scene_type
  use bw_study_frame, only: study_frame
  use bw_text, only: append, string
  use bw_timed_runs, only: repeat_runs, run_first, timed_run
  implicit none (type, external)
  private
  public :: compare_effects

  real(dp), parameter :: budget = 0.5_dp         !! s of repeats for each scene
  real(dp), parameter :: noticeable = 0.01_dp    !! chosen: relative change that matters if the scene has no tolerance

  type :: effects_study
    type(timed_run), allocatable :: runs(:)      !! of the compared scenes, the first of which is studied
    type(case_result), allocatable :: results(:) !! of the same scenes, as long as needed
    type(effect_list) :: list
    type(string), allocatable :: notes(:)
    logical :: trusted = .true.
  end type effects_study

contains

  subroutine compare_effects(scene, directory, overwrite, progress, outcome, error)
    !! Compare, write DIRECTORY/<scene>.effects.nc, and report what was found.
    !! **Errors**: `status_bad_file` if a file cannot be read or written or belongs to another scene.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(effects_study) :: state
    type(study_frame) :: frame
    logical :: whole
    frame%study = 'effects'
    call frame%begin(scene, directory, overwrite, outcome, error)
    if (allocated(error) .or. outcome%was_there) return
    call progress%begin(scene%name, 1_i8, 0_i8)
    call compare(frame%scene, progress, state, whole)
    call progress%end()
    if (.not. whole) then
      call frame%leave(outcome)
      return
    end if
    call frame%end(scene, effect_values(state%list), effect_report(state%list), state%notes, outcome, error)
    if (.not. state%trusted) outcome%status = status_not_trusted
  end subroutine compare_effects

  subroutine compare(scene, progress, state, whole)
    !! Run every scene once, for what it yields, then all in turn for their seconds.
    type(scene_type), intent(in) :: scene
    class(progress_type), intent(inout), target :: progress
    type(effects_study), intent(inout) :: state
    logical, intent(out) :: whole                !! false if the monitor asked to stop
    type(compared_scenes) :: scenes
    integer :: i
    call pairs_of(scene, scenes)
    state%list%rows = scenes%rows
    allocate (state%runs(size(scenes%variants%scenes)), state%results(size(scenes%variants%scenes)))
    do i = 1, size(state%runs)
      state%runs(i)%scene = scenes%variants%scenes(i)
    end do
    call run_scene_once(1, progress, state, whole)
    if (.not. whole) return
    call start_list(scene, state)
    do i = 1, size(state%list%rows)
      call compare_pair(i, progress, state, whole)
      if (.not. whole) return
      call forget(i, state)
    end do
    call note_untrusted(state)
    call repeat_runs(state%runs, budget, progress, whole)
    if (whole) call take_seconds(state)
  end subroutine compare

  subroutine start_list(scene, state)
    !! Choose the modes to compare, and the threshold for their changes.
    type(scene_type), intent(in) :: scene
    type(effects_study), intent(inout) :: state
    associate (list => state%list, result => state%results(1))
      list%mode_count = min(compared_modes, result%modes%count)
      list%tolerance = noticeable
      list%tolerance_source = 'since the scene has no tolerance'
      if (by_tolerance(scene%modes) .and. scene%modes%asked) then
        list%tolerance = scene%modes%tolerance
        list%tolerance_source = 'the tolerance of the scene'
      else if (left_by_counts(result) > 0.0_dp) then
        list%tolerance = left_by_counts(result)
        list%tolerance_source = 'the error of the displacement over its peak with the scene''s counts of modes'
      end if
    end associate
  end subroutine start_list

  pure real(dp) function left_by_counts(result) result(error)
    !! Return the truncation error of the displacement by the scene's counts, over the peak; 0 without an estimate.
    type(case_result), intent(in) :: result
    error = 0.0_dp
    if (.not. allocated(result%response)) return
    if (.not. allocated(result%response%displacement_error)) return
    if (peak_of(result) > 0.0_dp) error = maxval(result%response%displacement_error)/peak_of(result)
  end function left_by_counts

  pure real(dp) function peak_of(result) result(peak)
    !! Return the largest displacement, m; 0 without a history.
    type(case_result), intent(in) :: result
    peak = 0.0_dp
    if (.not. allocated(result%response)) return
    if (result%response%finite_samples > 0) then
      peak = maxval(abs(result%response%displacement(:result%response%finite_samples, :)))
    end if
  end function peak_of

  subroutine compare_pair(row, progress, state, whole)
    !! Fill a row from its two scenes.
    integer, intent(in) :: row
    class(progress_type), intent(inout), target :: progress
    type(effects_study), intent(inout) :: state
    logical, intent(out) :: whole
    whole = .true.
    associate (i => state%list%rows(row)%place_with, j => state%list%rows(row)%place_without)
      if (i == 0) return
      call run_scene_once(i, progress, state, whole)
      if (whole) call run_scene_once(j, progress, state, whole)
      if (.not. whole) return
      associate (with => state%results(i), without => state%results(j))
        state%list%rows(row)%with = compared(with)
        state%list%rows(row)%without = compared(without)
        call compare_frequencies(state%list%rows(row), state%list%tolerance)
        call compare_responses(with, without, peak_of(state%results(1)), state%list%rows(row)%response_change)
        state%list%rows(row)%response_error = error_of_both(with, without, peak_of(state%results(1)))
        state%list%rows(row)%is_whole = with%status == case_done .and. without%status == case_done
      end associate
    end associate
  end subroutine compare_pair

  subroutine run_scene_once(place, progress, state, whole)
    !! Run a scene, unless its result is known. The time of a run that exceeds the budget of its repeats is taken from this run.
    integer, intent(in) :: place
    class(progress_type), intent(inout), target :: progress
    type(effects_study), intent(inout) :: state
    logical, intent(out) :: whole
    whole = .true.
    if (allocated(state%results(place)%modes)) return
    call run_first(state%runs, place, budget, budget, progress, state%results(place), whole)
  end subroutine run_scene_once

  type(compared_case) function compared(result) result(numbers)
    !! Return the compared quantities of a case: its modes after the last event at t = 0.
    type(case_result), intent(in) :: result
    integer :: n
    n = min(compared_modes, result%modes%count)
    associate (frequency => values_of(result, 'angular_frequency'), phase => values_of(result, 'phase_velocity'), &
               group => values_of(result, 'group_velocity'))
      numbers%angular_frequency(:n) = frequency(:n)
      numbers%phase_velocity(:n) = phase(:n)
      numbers%group_velocity(:n) = group(:n)
    end associate
  end function compared

  pure subroutine compare_responses(with, without, peak, change)
    !! Find the largest difference of two displacements over the peak, at samples that are finite in both.
    type(case_result), intent(in) :: with, without
    real(dp), intent(in) :: peak                   !! of the scene's own, m
    real(dp), intent(inout) :: change              !! stays missing unless both histories exist
    integer :: finite
    if (.not. (allocated(with%response) .and. allocated(without%response))) return
    finite = min(with%response%finite_samples, without%response%finite_samples)
    if (finite == 0) return
    change = 0.0_dp
    if (peak > 0.0_dp) change = maxval(abs(with%response%displacement(:finite, :)/peak &
                                           - without%response%displacement(:finite, :)/peak))
  end subroutine compare_responses

  pure real(dp) function error_of_both(with, without, peak) result(error)
    !! Return the sum of estimated errors of two displacements over the peak; missing if one has no estimate.
    type(case_result), intent(in) :: with, without
    real(dp), intent(in) :: peak                   !! of the scene's own, m
    error = missing
    if (.not. (allocated(with%response) .and. allocated(without%response)) .or. .not. peak > 0.0_dp) return
    if (.not. (allocated(with%response%displacement_error) .and. allocated(without%response%displacement_error))) return
    error = (maxval(with%response%displacement_error) + maxval(without%response%displacement_error))/peak
  end function error_of_both

  subroutine note_untrusted(state)
    !! Note each run with untrusted numbers once: the rows it belongs to, and why.
    type(effects_study), intent(inout) :: state
    character(:), allocatable :: rows
    integer :: place, i
    do place = 1, size(state%results)
      if (state%results(place)%status == case_done) cycle
      state%trusted = .false.
      rows = ''
      do i = 1, size(state%list%rows)
        associate (row => state%list%rows(i))
          if (place == row%place_with) rows = rows//', '//in_words(row%effect)//' (the run with it)'
          if (place == row%place_without) rows = rows//', '//in_words(row%effect)//' (the run without it)'
        end associate
      end do
      if (place == 1) rows = ', the scene itself'
      call append(state%notes, 'not trusted: '//rows(3:)//': '//why_untrusted(state%results(place)%notes))
    end do
  end subroutine note_untrusted

  subroutine forget(row, state)
    !! Release the histories that no later row needs, as they may be large.
    integer, intent(in) :: row
    type(effects_study), intent(inout) :: state
    integer :: place
    do place = 2, size(state%results)
      if (any([state%list%rows(row + 1:)%place_with, state%list%rows(row + 1:)%place_without] == place)) cycle
      if (allocated(state%results(place)%response)) deallocate (state%results(place)%response)
    end do
  end subroutine forget

  pure subroutine take_seconds(state)
    !! Put the median times into the rows.
    type(effects_study), intent(inout) :: state
    integer :: i
    do i = 1, size(state%list%rows)
      associate (row => state%list%rows(i))
        if (row%place_with == 0) cycle
        row%seconds_with = state%runs(row%place_with)%seconds%median()
        row%seconds_without = state%runs(row%place_without)%seconds%median()
      end associate
    end do
  end subroutine take_seconds

end module bw_effects
