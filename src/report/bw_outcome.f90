module bw_outcome
  !! The outcome of a scene: its status, report and notes.
  use bw_case_result, only: case_done
  use bw_error, only: status_done, status_not_trusted, status_stopped
  use bw_existing_result, only: existing_result
  use bw_kinds, only: i1, i8
  use bw_report, only: notes_report
  use bw_result_draft, only: not_done
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_summary, only: scene_heading, scene_summary
  use bw_text, only: text_builder, text_of
  implicit none (type, external)
  private

  character(*), parameter, public :: unfinished_work_removed = &
    'unfinished work, damaged or of another scene or version, was removed'

  type, public :: outcome_type
    integer :: status = status_done           !! an exit status
    logical :: was_there = .false.            !! a finished result existed already
    character(:), allocatable :: file         !! the result
    character(:), allocatable :: report       !! what to print
    character(:), allocatable :: notes        !! lines, also in the result: warnings and remarks
    character(:), allocatable :: warnings         !! warnings about this run, lines, not in the result
  contains
    procedure :: tell
    procedure :: set_found
    procedure :: set_notes
    procedure :: trust
    procedure :: notes_text
    procedure :: set_report
    procedure :: set_stopped
    procedure :: set_part, set_part_without_case
  end type outcome_type

contains

  subroutine tell(self, text)
    !! Add a warning about this run.
    class(outcome_type), intent(inout) :: self
    character(*), intent(in) :: text          !! a line
    if (.not. allocated(self%warnings)) self%warnings = ''
    self%warnings = self%warnings//text//new_line('a')
  end subroutine tell

  subroutine set_found(self, scene, layout, existing)
    !! Report an existing finished result again.
    class(outcome_type), intent(inout) :: self
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(existing_result), intent(in) :: existing
    self%was_there = .true.
    self%notes = existing%notes
    if (self%notes /= '') self%notes = self%notes//new_line('a')
    self%report = scene_heading(scene)//scene_summary(scene, layout)//existing%report//new_line('a')
    if (existing%notes /= '') self%report = self%report//notes_report(existing%notes)//new_line('a')
    self%report = self%report//'  '//self%file//': nothing to do, the result of this scene is there'
    if (existing%not_trusted > 0) self%report = self%report//'; '//text_of(existing%not_trusted)//' of its cases '// &
      'cannot be trusted, as its notes say'
    self%report = self%report//new_line('a')
  end subroutine set_found

  subroutine set_notes(self, notes, layout, not_trusted)
    !! Set the notes, and the status that follows from them.
    class(outcome_type), intent(inout) :: self
    character(*), intent(in) :: notes         !! of all cases; lines
    type(result_layout), intent(in) :: layout
    integer(i8), intent(in) :: not_trusted    !! cases with numbers that cannot be trusted
    self%notes = notes
    if (not_trusted == 0) return
    self%status = status_not_trusted
    if (layout%cases > 0) self%notes = text_of(not_trusted)//' of '//text_of(layout%cases)// &
      ' cases hold numbers that cannot be trusted'//new_line('a')//notes
  end subroutine set_notes

  pure subroutine trust(self, trusted)
    !! Set the status to not trusted if findings beside the cases cannot be trusted.
    class(outcome_type), intent(inout) :: self
    logical, intent(in) :: trusted
    if (.not. trusted) self%status = max(self%status, status_not_trusted)
  end subroutine trust

  pure function notes_text(self) result(text)
    !! Return the notes without the last line end.
    class(outcome_type), intent(in) :: self
    character(:), allocatable :: text
    text = without_last_end(self%notes)
  end function notes_text

  pure function without_last_end(lines) result(text)
    !! Remove the last line end.
    character(*), intent(in) :: lines
    character(:), allocatable :: text
    text = lines(:max(0, len(lines) - 1))
  end function without_last_end

  subroutine set_report(self, scene, layout, body, taken_over, times)
    !! Set the report of a finished scene.
    class(outcome_type), intent(inout) :: self
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: body          !! the case, or the table of cases
    integer(i8), intent(in) :: taken_over     !! cases finished by an earlier run
    character(*), intent(in) :: times         !! the table of stages
    type(text_builder) :: report
    call report%append(scene_heading(scene))
    call report%append(scene_summary(scene, layout))
    call report%append(body)
    if (taken_over > 0) call report%append_line('  '//text_of(taken_over)//' cases were taken over from an earlier run')
    call report%append_line('')
    if (allocated(self%warnings)) call report%append(notes_report(without_last_end(self%warnings)))
    if (len(self%notes_text()) > 0) then
      call report%append_line(notes_report(self%notes_text()))
    else if (allocated(self%warnings)) then
      call report%append_line('')
    end if
    call report%append(times)
    call report%append_line('  result     '//self%file)
    self%report = report%text()
  end subroutine set_report

  subroutine set_part(self, scene, part, parts, statuses)
    !! Report a part of a sweep that is finished while others are not.
    class(outcome_type), intent(inout) :: self
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: part, parts
    integer(i1), intent(in) :: statuses(:)    !! of all cases, `not_done` for unfinished ones, (cases)
    integer, parameter :: shown = 10          ! unfinished parts
    integer :: failed, missing, p, waiting
    failed = count(statuses(part::parts) /= case_done)
    if (failed > 0) self%status = status_not_trusted
    self%notes = ''
    if (failed > 0) self%notes = text_of(failed)//' of the '//text_of(size(statuses(part::parts)))//' cases of part '// &
      text_of(part)//' hold numbers that cannot be trusted'//new_line('a')
    self%report = scene_heading(scene)//'  part '//text_of(part)//' of '//text_of(parts)//' is done: '// &
      text_of(size(statuses(part::parts)))//' of '//text_of(size(statuses))//' cases'//new_line('a')
    if (all(statuses /= not_done)) self%report = self%report// &
      '  no case is missing; the last running part finishes '//self%file//new_line('a')
    waiting = 0
    do p = 1, min(parts, size(statuses))      ! further parts have no cases
      missing = count(statuses(p::parts) == not_done)
      if (missing == 0) cycle
      waiting = waiting + 1
      if (waiting <= shown) self%report = self%report//'  missing    '//text_of(missing)//' of the '// &
        text_of(size(statuses(p::parts)))//' cases of part '//text_of(p)//new_line('a')
    end do
    if (waiting > shown) self%report = self%report//'  missing    cases of '//text_of(waiting - shown)//' further parts'// &
      new_line('a')
  end subroutine set_part

  subroutine set_part_without_case(self, scene, part, parts)
    !! Report a part without a case, of a scene that has one case only.
    class(outcome_type), intent(inout) :: self
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: part, parts
    self%notes = ''
    self%report = scene_heading(scene)//'  part '//text_of(part)//' of '//text_of(parts)// &
      ' has nothing to do: the scene has one case, which is part 1'//new_line('a')
  end subroutine set_part_without_case

  subroutine set_stopped(self, saved, cases)
    !! Report unfinished work.
    class(outcome_type), intent(inout) :: self
    integer(i8), intent(in) :: saved, cases
    self%status = status_stopped
    self%report = ''
    self%notes = self%file//': stopped with '//text_of(saved)//' of '//text_of(cases)// &
      ' cases saved; the same command goes on from there'//new_line('a')
  end subroutine set_stopped

end module bw_outcome
