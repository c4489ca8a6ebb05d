module bw_scene_tally
  !! Output for several scenes on a command line: one line for each of many, and a final count.
  use bw_error, only: status_done, status_not_trusted
  use bw_note, only: is_remark, kind_of
  use bw_text, only: lines_of, string, text_of
  implicit none (type, external)
  private
  public :: warning_kinds, without_case

  integer, parameter :: most_reports = 10      !! scenes whose reports are printed in full

  type, public :: scene_tally
    !! Numbers of scenes by outcome.
    integer :: scenes = 0                      !! that were named
    integer :: wrong = 0                       !! that could not be read, or were refused
    integer :: good = 0                        !! finished successfully
    integer :: there = 0                       !! of the good: with existing results
    integer :: warned = 0                      !! of the good: with warnings
    integer :: not_trusted = 0                 !! with numbers that cannot be trusted
    integer :: failed = 0                      !! that ended otherwise
  contains
    procedure :: is_brief
    procedure :: count_end
    procedure :: text => text_of_tally
  end type scene_tally

contains

  pure logical function is_brief(self)
    !! Return whether there are so many scenes that each has one line.
    class(scene_tally), intent(in) :: self
    is_brief = self%scenes > most_reports
  end function is_brief

  pure subroutine count_end(self, status, notes)
    !! Count a finished scene.
    class(scene_tally), intent(inout) :: self
    integer, intent(in) :: status              !! its exit status
    character(*), intent(in) :: notes          !! lines
    select case (status)
    case (status_done)
      self%good = self%good + 1
      if (warning_kinds(notes) /= '') self%warned = self%warned + 1
    case (status_not_trusted); self%not_trusted = self%not_trusted + 1
    case default; self%failed = self%failed + 1
    end select
  end subroutine count_end

  pure function text_of_tally(self, good) result(text)
    !! Return the count, `500 scenes: 497 done (12 with warnings), 3 wrong`; empty for a single scene.
    class(scene_tally), intent(in) :: self
    character(*), intent(in) :: good           !! word for good scenes
    character(:), allocatable :: text, aside
    integer :: left
    text = ''
    if (self%scenes < 2) return
    aside = ''
    if (self%there > 0) aside = aside//', '//text_of(self%there)//' there already'
    if (self%warned > 0) aside = aside//', '//text_of(self%warned)//' with warnings'
    if (aside /= '') aside = ' ('//aside(3:)//')'
    text = text_of(self%scenes)//' scenes: '//text_of(self%good)//' '//good//aside
    if (self%not_trusted > 0) text = text//', '//text_of(self%not_trusted)//' with numbers that cannot be trusted'
    if (self%wrong > 0) text = text//', '//text_of(self%wrong)//' wrong'
    if (self%failed > 0) text = text//', '//text_of(self%failed)//' not finished'
    left = self%scenes - self%good - self%not_trusted - self%wrong - self%failed
    if (left > 0) text = text//', '//text_of(left)//' not begun'
  end function text_of_tally

  pure function warning_kinds(notes) result(kinds)
    !! Return the kinds of warnings among notes, separated by commas; empty if there are none.
    character(*), intent(in) :: notes          !! lines
    character(:), allocatable :: kinds
    type(string), allocatable :: lines(:)
    integer :: i
    kinds = ''
    lines = lines_of(notes)
    do i = 1, size(lines)
      if (is_remark(lines(i)%text)) cycle
      if (kinds /= '') kinds = kinds//', '
      kinds = kinds//kind_of(without_case(lines(i)%text))
    end do
  end function warning_kinds

  pure function without_case(line) result(text)
    !! Return a note of a sweep without its list of cases.
    character(*), intent(in) :: line
    character(:), allocatable :: text
    text = line
    if (index(line, 'case ') == 1) text = line(index(line, ': ') + 2:)
  end function without_case

end module bw_scene_tally
