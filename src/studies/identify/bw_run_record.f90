module bw_run_record
  !! A record with a beam: its lines, then the beam's modes beside them, and the unknowns of the beam from them.
  !!
  !! First the record, and those of further scenes, are run like any other, each with its own result. What the beam says is put into
  !! the scene's finished result; one that has it already is left alone.
  use bw_absent_mends, only: find_mends, mend_type
  use bw_beam_fit, only: unlikely
  use bw_beam_state, only: beam_state, state_of
  use bw_error, only: error_type, fail, status_bad_file, status_stopped
  use bw_files, only: remove_file
  use bw_further_scenes, only: further_scenes
  use bw_identification, only: identification, identify
  use bw_identified_scene, only: identified_text, write_identified
  use bw_identify_par, only: identify_par
  use bw_input_values, only: position_of
  use bw_kinds, only: dp, i4, i8
  use bw_model_comparison, only: compare_case, match_lines, misfit_type
  use bw_model_file, only: model_findings, read_attribute, write_model
  use bw_model_report, only: explained_text, loose_text, report_comparison, report_identified, report_mends
  use bw_monitor, only: progress_type
  use bw_outcome, only: outcome_type
  use bw_process_group, only: process_group
  use bw_quantile, only: normal_quantile
  use bw_record_lines, only: status_words
  use bw_result_lines, only: read_result_lines, result_lines
  use bw_run_scene, only: run_scene
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  use bw_scene_states, only: measured_scene, states_of, unknowns_in
  use bw_text, only: text_builder, text_of
  implicit none (type, external)
  private
  public :: run_record

  character, parameter :: nl = new_line('a')
  integer, parameter :: shown_cases = 8          !! of a sweep, in the report
  integer, parameter :: harmonic = findloc(status_words == 'harmonic', .true., dim=1) - 1   !! bit of a line that is no mode

  type :: record_set
    !! All that is fitted together: the cases of the scene, then those of further scenes.
    type(measured_scene), allocatable :: measured(:)     !! (cases of all scenes)
    type(result_lines), allocatable :: lines(:)          !! (the same)
    integer :: own = 0                                   !! cases of the scene itself
    type(scene_type), allocatable :: further(:)
    character(:), allocatable :: identity                !! of what lies beside the scene's own result
  end type record_set

contains

  subroutine run_record(scene, directory, overwrite, group, progress, outcome, error)
    !! Run a scene with a record; like `run_scene`, which is all of it where there is no beam.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(process_group), intent(inout) :: group
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(record_set) :: set
    type(outcome_type) :: other
    real(dp) :: nothing(0)
    integer(i4), allocatable :: stop(:)
    integer :: i
    outcome%notes = ''
    outcome%report = ''
    call further_scenes(scene, set%further, error)
    call group%collect(nothing, error)
    if (allocated(error)) return
    do i = 1, size(set%further)
      call run_scene(set%further(i), directory, overwrite, group, progress, other, error)
      call group%collect(nothing, error)
      stop = [merge(1_i4, 0_i4, other%status == status_stopped)]
      call group%share(stop)
      outcome%status = max(outcome%status, other%status)
      outcome%notes = other%notes
      if (allocated(error) .or. stop(1) == 1) return
    end do
    if (group%leads()) call clear_outdated(scene, directory, overwrite, set, error)
    call group%collect(nothing, error)
    if (allocated(error)) return
    i = outcome%status
    call run_scene(scene, directory, overwrite, group, progress, outcome, error)
    outcome%status = max(outcome%status, i)
    if (position_of(scene%groups, 'beam') == 0 .or. .not. group%leads()) return
    if (allocated(error) .or. outcome%status == status_stopped) return
    call hold_against(scene, directory, progress, set, outcome, error)
  end subroutine run_record

  subroutine clear_outdated(scene, directory, overwrite, set, error)
    !! A finished result whose further records were others is not this one.
    !! **Errors**: it may not be replaced.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    type(record_set), intent(inout) :: set
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: path, there
    integer :: ignored
    call find_identity(directory, set)
    path = directory//'/'//scene%name//'.nc'
    call read_attribute(path, 'model', there)
    if (there == '' .or. there == set%identity) return
    if (overwrite) then
      ignored = remove_file(path)
    else
      call fail(error, status_bad_file, path//': is there already, of other records; --overwrite replaces it')
    end if
  end subroutine clear_outdated

  subroutine hold_against(scene, directory, progress, set, outcome, error)
    !! The beam beside the lines that were found.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    class(progress_type), intent(inout) :: progress
    type(record_set), intent(inout) :: set
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    type(model_findings) :: findings
    character(:), allocatable :: there, report, notes
    type(text_builder) :: lines
    real(dp) :: quantile
    call read_attribute(outcome%file, 'model', there)
    if (outcome%was_there .and. there == set%identity) return
    quantile = normal_quantile(0.5_dp + 0.5_dp*scene%spectrum%confidence)
    call read_all(scene, directory, quantile, set, error)
    if (allocated(error)) return
    if (progress%stop_requested()) return
    notes = ''
    if (size(scene%unknowns) > 0) then
      call identify_beam(scene, quantile, set, findings, lines, notes)
      call write_scenes(directory, set, findings%found, lines, error)
    else
      call compare(set, findings, lines, notes)
    end if
    if (allocated(error)) return
    call read_attribute(outcome%file, 'report', report)
    call read_attribute(outcome%file, 'notes', findings%notes)
    if (findings%notes /= '' .and. notes /= '') findings%notes = findings%notes//nl
    findings%notes = findings%notes//notes(:max(0, len(notes) - 1))
    findings%report = report//lines%text()
    findings%identity = set%identity
    call write_model(outcome%file, findings, error)
    outcome%notes = outcome%notes//notes
    outcome%report = outcome%report//lines%text()
    outcome%was_there = .false.
  end subroutine hold_against

  subroutine find_identity(directory, set)
    !! What the findings rest on beside the scene's own result: the scenes of further results, and their records.
    character(*), intent(in) :: directory
    type(record_set), intent(inout) :: set
    character(:), allocatable :: scene, checksums
    integer :: i
    set%identity = 'modes beside lines'
    do i = 1, size(set%further)
      call read_attribute(directory//'/'//set%further(i)%name//'.nc', 'scene', scene)
      call read_attribute(directory//'/'//set%further(i)%name//'.nc', 'record_checksum', checksums)
      set%identity = set%identity//nl//scene//checksums
    end do
  end subroutine find_identity

  subroutine read_all(scene, directory, quantile, set, error)
    !! The scenes and lines of all cases.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    real(dp), intent(in) :: quantile
    type(record_set), intent(inout) :: set
    type(error_type), allocatable, intent(inout) :: error
    integer :: i, n
    n = int(case_count(scene))
    set%own = n
    do i = 1, size(set%further)
      n = n + int(case_count(set%further(i)))
    end do
    allocate (set%measured(n), set%lines(n))
    n = 0
    call read_cases(scene)
    do i = 1, size(set%further)
      call read_cases(set%further(i))
    end do
  contains
    subroutine read_cases(one)
      type(scene_type), intent(in) :: one
      type(result_lines), allocatable :: cases(:)
      integer :: c
      if (allocated(error)) return
      call read_result_lines(directory//'/'//one%name//'.nc', quantile, cases, error)
      do c = 1, int(case_count(one))
        if (allocated(error)) return
        n = n + 1
        set%lines(n) = cases(c)
        set%measured(n)%lines = cases(c)%lines
        call case_scene(one, int(c, i8), set%measured(n)%scene, error)
      end do
    end subroutine read_cases
  end subroutine read_all

  subroutine compare(set, findings, lines, notes)
    !! Lines beside modes, case by case: nothing is unknown.
    type(record_set), intent(inout) :: set
    type(model_findings), intent(inout) :: findings
    type(text_builder), intent(inout) :: lines
    character(:), allocatable, intent(inout) :: notes
    type(beam_state) :: state
    type(identify_par) :: none(0)
    type(identification) :: found                !! without unknowns
    type(mend_type), allocatable :: mends(:)
    real(dp) :: nothing(0)
    integer :: c
    allocate (findings%cases(set%own), findings%misfits(set%own))
    do c = 1, set%own
      associate (measured => set%lines(c), misfit => findings%misfits(c))
        state = state_of(set%measured(c)%scene, none, set%measured(c)%lines)
        state%foreign = btest(measured%status, harmonic)
        call match_lines(state, misfit)
        call compare_case(measured, state, nothing, findings%cases(c))
        if (size(measured%error) == 0 .or. c > shown_cases) cycle
        call report_comparison('Lines beside the modes of the beam'//case_text(set, c), measured, findings%cases(c), lines)
        call lines%append_line('  Misfit: '//explained_text(misfit))
        call note_misfit(misfit, case_text(set, c), notes)
        if (.not. misfit%tail < unlikely) cycle
        found%fit%mode_of = state%mode_of
        call find_mends(set%measured(c:c), found, mends)
        call report_mends(mends, lines)
      end associate
    end do
  end subroutine compare

  pure function case_text(set, c) result(text)
    !! Which case, where there are several.
    type(record_set), intent(in) :: set
    integer, intent(in) :: c
    character(:), allocatable :: text
    text = ''
    if (size(set%measured) == 1) return
    text = ', case '//text_of(c)
    if (c > set%own) text = ', '//set%measured(c)%scene%name
  end function case_text

  subroutine note_misfit(misfit, which, notes)
    !! A model that does not explain the lines is told so.
    type(misfit_type), intent(in) :: misfit
    character(*), intent(in) :: which
    character(:), allocatable, intent(inout) :: notes
    character(:), allocatable :: text
    text = explained_text(misfit)
    if (index(text, 'does not') > 0) notes = notes//'misfit'//which//': '//text//nl
  end subroutine note_misfit

  subroutine identify_beam(scene, quantile, set, findings, lines, notes)
    !! All cases together.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: quantile
    type(record_set), intent(inout) :: set
    type(model_findings), intent(inout) :: findings
    type(text_builder), intent(inout) :: lines
    character(:), allocatable, intent(inout) :: notes
    type(beam_state), allocatable :: states(:)
    type(mend_type), allocatable :: mends(:)
    type(identification) :: found
    integer :: c, i
    call states_of(set%measured, states)
    do c = 1, size(states)
      states(c)%foreign = btest(set%lines(c)%status, harmonic)
    end do
    call identify(states, scene%unknowns, quantile, found)
    allocate (findings%cases(size(states)), findings%misfits(1))
    findings%misfits(1) = misfit_type(found%fit%chi_squared, found%fit%freedom, found%fit%tail, found%fit%scatter)
    do c = 1, size(states)
      call compare_case(set%lines(c), states(c), found%values, findings%cases(c))
      if (c > shown_cases .or. size(set%lines(c)%error) == 0) cycle
      call report_comparison('Lines beside the modes of the identified beam'//case_text(set, c), set%lines(c), &
                             findings%cases(c), lines)
    end do
    findings%cases = findings%cases(:set%own)
    call report_identified(found, scene%spectrum%confidence, lines)
    call lines%append_line('  Misfit: '//explained_text(findings%misfits(1)))
    call note_misfit(findings%misfits(1), '', notes)
    do i = 1, size(found%loose)
      notes = notes//'not fixed: '//loose_text(found, i)//nl
    end do
    if (.not. found%explained) then
      call find_mends(set%measured, found, mends)
      call report_mends(mends, lines)
    end if
    findings%found = found
  end subroutine identify_beam

  subroutine write_scenes(directory, set, found, lines, error)
    !! The identified scenes, the scene's own and the further ones.
    character(*), intent(in) :: directory
    type(record_set), intent(in) :: set
    type(identification), intent(in) :: found
    type(text_builder), intent(inout) :: lines
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: path
    integer :: c
    path = ''
    do c = 1, size(set%measured)
      if (c > 1) then
        if (set%measured(c)%scene%name == set%measured(c - 1)%scene%name) cycle
      end if
      path = directory//'/'//set%measured(c)%scene%name//'.identified.nml'
      call write_identified(path, identified_text(set%measured(c)%scene, &
                                                  unknowns_in(set%measured(1)%scene, set%measured(c)%scene), found), error)
      if (allocated(error)) return
      call lines%append_line('  identified '//path)
    end do
  end subroutine write_scenes

end module bw_run_record
