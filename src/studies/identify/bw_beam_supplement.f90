module bw_beam_supplement
  !! Comparison of a scene's beam with the lines of its record, and identification of its unknowns: an addition to the
  !! result of a record.
  use bw_corrected_models, only: find_corrections, corrected_model
  use bw_measured_state, only: measured_state, state_of
  use bw_calibration, only: calibration_text
  use bw_classic_head, only: classic_head
  use bw_error, only: error_type
  use bw_files, only: cannot_be_written
  use bw_fit_problem, only: is_at_end
  use bw_fit_search, only: misfit_type, misfit_chance
  use bw_identification, only: identification, identify
  use bw_identified_scene, only: identified_attribute, identified_path, identified_room, identified_text
  use bw_identified_waves, only: put_identified_waves
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp, i8
  use bw_lost_lines, only: are_lost, lost_text
  use bw_measured_damping, only: measured_damping
  use bw_missing, only: missing
  use bw_model_comparison, only: compare_case, match_lines
  use bw_model_file, only: model_findings, model_rows, put_misfit
  use bw_modelled_response, only: find_modelled_response
  use bw_model_report, only: explained_text, loose_text, report_comparison, report_identified, report_corrections
  use bw_monitor, only: monitor_type, part_monitor
  use bw_notes, only: notes_type
  use bw_quantile, only: normal_quantile
  use bw_record_lines, only: status_words
  use bw_record_set, only: read_all, record_set
  use bw_result_layout, only: has
  use bw_result_supplement, only: result_supplement
  use bw_result_table, only: of_supplement, result_table
  use bw_scene, only: scene_type
  use bw_scene_states, only: all_unknowns, states_of, unknowns_in
  use bw_screen, only: details
  use bw_text, only: append, string, text_builder, text_of
  implicit none (type, external)
  private

  character, parameter :: nl = new_line('a')
  integer, parameter :: shown_cases = 8          !! of a sweep, printed
  integer, parameter :: harmonic = findloc(status_words == 'harmonic', .true., dim=1) - 1   !! bit of a line that is no mode

  type, extends(result_supplement), public :: beam_supplement
    type(scene_type) :: scene
    character(:), allocatable :: directory               !! of the results
    type(scene_type), allocatable :: further(:)          !! scenes of other states of the beam, whose results exist
  contains
    procedure :: attributes
    procedure :: rows
    procedure :: add
  end type beam_supplement

contains

  subroutine attributes(self, head)
    !! Add attributes that identify the data used, and room for the texts of identified scenes.
    class(beam_supplement), intent(in) :: self
    class(classic_head), intent(inout) :: head
    integer :: unknowns, i
    call head%add_text('model', self%identity, of_file=.true.)
    if (size(self%scene%unknowns) == 0) return
    unknowns = size(self%scene%unknowns) + sum([(size(self%further(i)%unknowns), i=1, size(self%further))])
    call head%add_room(identified_attribute(1), identified_room(self%scene%name, self%scene, unknowns))
    do i = 1, size(self%further)
      call head%add_room(identified_attribute(i + 1), identified_room(self%scene%name, self%further(i), unknowns))
    end do
  end subroutine attributes

  subroutine rows(self, table)
    !! Walk through the rows of the beam's variables.
    class(beam_supplement), intent(in) :: self
    class(result_table), intent(inout) :: table
    call model_rows(table, size(self%scene%unknowns) > 0)
  end subroutine rows

  subroutine add(self, draft, monitor, notes, report, whole, error)
    !! Put modes that match the lines, and identified values, into the result.
    !! **Errors**: a result cannot be read or written.
    class(beam_supplement), intent(inout) :: self
    class(result_table), intent(inout) :: draft
    class(monitor_type), intent(inout), target :: monitor
    character(:), allocatable, intent(inout) :: notes, report
    logical, intent(out) :: whole
    type(error_type), allocatable, intent(inout) :: error
    type(record_set) :: set
    type(model_findings) :: findings
    type(text_builder) :: lines
    type(part_monitor), target :: listener               ! the fits report no progress
    type(scene_type), allocatable :: identified(:)       ! the scene's own cases with identified values
    type(error_type), allocatable :: none
    character(:), allocatable :: more
    real(dp) :: quantile
    integer :: i
    whole = .true.
    listener%whole => monitor
    listener%start = 1.0_dp
    listener%share = 0.0_dp
    quantile = normal_quantile(0.5_dp + 0.5_dp*self%scene%spectrum%confidence)
    call read_all(self%scene, self%further, self%directory, draft%file%path, quantile, listener, set, error)
    set%places = draft%layout%profile
    if (has(draft%layout, 'hammer places')) then
      set%sensors = draft%layout%record%sensors
      set%frequencies = draft%layout%record%frequencies
    end if
    if (allocated(error)) return
    more = ''
    allocate (findings%scenes(0))
    if (size(self%scene%unknowns) > 0) then
      call identify_beam(self%scene, quantile, set, findings, lines, more)
      if (.not. are_lost(set%states)) then
        if (has(draft%layout, 'waves')) then
          allocate (identified(set%own))
          do i = 1, set%own                       ! each describes a beam, since its modes were found
            call set%states(i)%scene_at(findings%found%values, identified(i), none)
          end do
          call put_identified_waves(draft, identified, quantile, listener, more, lines)
        end if
        call list_scenes(self%scene, self%directory, set, findings, lines)
      end if
    else
      call compare(set, findings, lines, more)
    end if
    whole = .not. monitor%stop_requested()
    if (.not. whole) return
    notes = notes//more
    report = report//lines%text()
    self%trusted = findings%trusted()
    call draft%begin_section(of_supplement)
    call model_rows(draft, size(self%scene%unknowns) > 0, findings)
    do i = 1, size(findings%scenes)
      call draft%set_text(identified_attribute(i), findings%scenes(i)%text)
    end do
    if (.not. self%trusted) call put_misfit(draft)
    call draft%file%write()
    if (draft%file%problem /= 0) call cannot_be_written(error, draft%file%path, draft%file%problem)
  end subroutine add

  subroutine compare(set, findings, lines, notes)
    !! Compare lines with modes, case by case, without unknowns. Cases after the first are details.
    type(record_set), intent(inout) :: set
    type(model_findings), intent(inout) :: findings
    type(text_builder), intent(inout) :: lines
    character(:), allocatable, intent(inout) :: notes
    type(measured_state) :: state
    type(identify_par) :: none(0)
    type(identification) :: found                !! without unknowns
    type(text_builder), allocatable :: own(:)    !! sections, (cases)
    type(corrected_model), allocatable :: corrections(:)
    type(measured_state) :: states(1)
    type(string) :: calibration(1)
    type(notes_type) :: calibrations
    real(dp) :: nothing(0)
    integer :: c
    allocate (findings%cases(set%own), findings%misfits(set%own), own(set%own))
    do c = 1, set%own
      associate (measured => set%lines(c), misfit => findings%misfits(c))
        state = state_of(set%measured(c)%scene, none, set%measured(c)%lines)
        state%monitor => set%measured(c)%monitor
        state%is_harmonic = btest(measured%status, harmonic)
        call match_lines(state, misfit)
        call compare_case(measured, state, nothing, set%places, findings%cases(c))
        if (allocated(set%sensors)) call find_modelled_response(state, nothing, set%sensors, set%frequencies, state%monitor, &
                                                                findings%cases(c)%response)
        if (size(measured%error) == 0 .or. c > shown_cases) cycle
        call report_comparison('Lines beside the modes of the beam'//case_text(set, c), measured, findings%cases(c), own(c))
        if (all(state%mode_of == 0)) then
          call report_lost(state, nothing, case_text(set, c), own(c), notes)
          cycle
        end if
        call own(c)%append_line('  Misfit: '//explained_text(misfit))
        call note_misfit(misfit, case_text(set, c), notes)
        states(1) = state
        calibration(1)%text = calibration_text(states, nothing, set%sensors, .not. misfit%tail < misfit_chance)
        if (calibration(1)%text /= '') call calibrations%add(int(c, i8), calibration)
        if (.not. misfit%tail < misfit_chance) cycle
        found%fit%mode_of = state%mode_of
        found%fit%misfit_type = misfit
        call find_corrections(set%measured(c:c), found, corrections)
        call report_corrections(corrections, misfit%scatter, own(c))
      end associate
    end do
    do c = 1, set%own
      if (c == 1) call lines%append(own(c)%text())
      if (c > 1) call lines%append(details(own(c)%text()))
    end do
    notes = notes//calibrations%lines(merge(0, set%own, set%own == 1))
  end subroutine compare

  pure function case_text(set, c) result(text)
    !! Name the case, if there are several.
    type(record_set), intent(in) :: set
    integer, intent(in) :: c
    character(:), allocatable :: text
    text = ''
    if (size(set%measured) == 1) return
    text = ', case '//text_of(c)
    if (c > set%own .or. set%own == 1) text = ', '//set%measured(c)%scene%name
  end function case_text

  subroutine note_misfit(misfit, which, notes)
    !! Warn that a model does not explain the lines.
    type(misfit_type), intent(in) :: misfit
    character(*), intent(in) :: which
    character(:), allocatable, intent(inout) :: notes
    character(:), allocatable :: text
    text = explained_text(misfit)
    if (index(text, 'does not') > 0) notes = notes//'misfit'//which//': '//text//nl
  end subroutine note_misfit

  subroutine report_lost(state, values, which, lines, notes)
    !! Report that no line is a mode.
    type(measured_state), intent(inout) :: state
    real(dp), intent(in) :: values(:)
    character(*), intent(in) :: which            !! case
    type(text_builder), intent(inout) :: lines
    character(:), allocatable, intent(inout) :: notes
    character(:), allocatable :: text
    text = lost_text(state, values)
    call lines%append_line('  Misfit: '//text)
    notes = notes//'misfit'//which//': '//text//nl
  end subroutine report_lost

  subroutine identify_beam(scene, quantile, set, findings, lines, notes)
    !! Identify the unknowns from all cases; each of several is a detail. If no line is a mode, they are missing.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: quantile
    type(record_set), intent(inout) :: set
    type(model_findings), intent(inout) :: findings
    type(text_builder), intent(inout) :: lines
    character(:), allocatable, intent(inout) :: notes
    type(corrected_model), allocatable :: corrections(:)
    type(identification) :: found
    type(text_builder) :: compared
    character(:), allocatable :: calibration
    integer :: c, i
    call states_of(set%measured, set%states)
    do c = 1, size(set%states)
      set%states(c)%is_harmonic = btest(set%lines(c)%status, harmonic)
    end do
    call identify(set%states, all_unknowns(set%measured), quantile, found)
    allocate (findings%cases(size(set%states)), findings%misfits(1))
    findings%misfits(1) = found%fit%misfit_type
    do c = 1, size(set%states)
      call compare_case(set%lines(c), set%states(c), found%values, set%places, findings%cases(c))
      if (c > shown_cases .or. size(set%lines(c)%error) == 0) cycle
      call report_comparison('Lines beside the modes of the identified beam'//case_text(set, c), set%lines(c), &
                             findings%cases(c), compared)
    end do
    if (size(set%states) == 1) call lines%append(compared%text())
    if (size(set%states) > 1) call lines%append(details(compared%text()))
    findings%cases = findings%cases(:set%own)
    if (allocated(set%sensors)) call find_modelled_response(set%states(1), found%values, set%sensors, set%frequencies, &
                                                            set%states(1)%monitor, findings%cases(1)%response)
    if (are_lost(set%states)) then
      call report_lost(set%states(1), found%values, '', lines, notes)
      call forget(found, findings)
      return
    end if
    call report_identified(found, scene%spectrum%confidence, lines)
    call lines%append_line('  Misfit: '//explained_text(findings%misfits(1)))
    call note_misfit(findings%misfits(1), '', notes)
    do i = 1, size(found%values)
      if (is_at_end(found%fit%v(i))) notes = notes//found%unknowns(i)%parameter//' is at the end of its range'//nl
    end do
    do i = 1, size(found%loose)
      notes = notes//'not fixed: '//loose_text(found, i)//nl
    end do
    calibration = calibration_text(set%states(:set%own), found%values, set%sensors, found%explained)
    if (calibration /= '') then
      call lines%append_line('  '//calibration)
      notes = notes//calibration//nl
    end if
    if (.not. found%explained) then
      call find_corrections(set%measured, found, corrections)
      call report_corrections(corrections, found%fit%scatter, lines)
    end if
    findings%found = found
  end subroutine identify_beam

  subroutine forget(found, findings)
    !! Mark all unknowns as not identified.
    type(identification), intent(inout) :: found
    type(model_findings), intent(inout) :: findings
    found%explained = .false.
    found%values = missing
    found%low = missing
    found%high = missing
    found%uncertainty%correlation = missing
    findings%misfits%scatter = missing
    if (allocated(findings%cases(1)%response)) findings%cases(1)%response = cmplx(missing, missing, dp)
    findings%found = found
  end subroutine forget

  subroutine list_scenes(scene, directory, set, findings, lines)
    !! List the identified scenes, the scene's own and further ones, and their files.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    type(record_set), intent(in) :: set
    type(model_findings), intent(inout) :: findings
    type(text_builder), intent(inout) :: lines
    character(:), allocatable :: own, further
    integer :: c, i
    own = set%measured(1)%scene%name
    do c = 1, size(set%measured)
      associate (one => set%measured(c)%scene)
        further = one%name
        if (c <= set%own) further = ''
        if (c > 1) then
          if (one%name == set%measured(c - 1)%scene%name) cycle
        end if
        call append(findings%scenes, identified_text(own, one, unknowns_in(set%measured, c), findings%found, &
          measured_damping(set%states, [(set%measured(i)%scene%name == one%name, i=1, size(set%states))], &
                           scene%spectrum%confidence, scene%spectrum%false_alarm)))
        call lines%append_line('  identified '//identified_path(directory//'/'//own//'.nc', further))
      end associate
    end do
  end subroutine list_scenes

end module bw_beam_supplement
