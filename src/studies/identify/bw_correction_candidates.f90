module bw_correction_candidates
  !! Candidate errors of a model that does not explain its lines: missing effects and doubtful inputs. Each is put into
  !! the scenes as text, with unknowns of its own if it has a size.
  use bw_effect_table, only: added, correction_table, correction_type, effect_number, effect_table, given, toggled
  use bw_error, only: error_type
  use bw_input_name, only: name_length
  use bw_input_table, only: name_row, name_table
  use bw_input_values, only: positions_of
  use bw_kinds, only: dp
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use bw_scene_resolved, only: resolved_text
  use bw_scene_scales, only: own_size
  use bw_scene_states, only: measured_scene
  use bw_scene_variant, only: has_group, with_value
  use bw_text, only: string, text_of, words_of
  implicit none (type, external)
  private
  public :: list_candidates, apply_correction

  character, parameter :: nl = new_line('a')

  type, public :: correction_candidate
    !! A row of the table of corrections for a scene.
    character(40) :: effect = ''                 !! in words
    character(name_length) :: group = ''         !! that it concerns
    logical :: added = .false.                   !! the group is new, else the scene has it
    character(name_length) :: place = ''         !! the group as unknowns name it
    character(32) :: values = ''                 !! further settings: `name = value`
    character(name_length) :: unknown(2) = ''    !! names of its unknowns
    real(dp) :: first(2) = 0.0_dp, last(2) = 0.0_dp    !! their ranges
    real(dp) :: neutral(2) = 0.0_dp              !! values without effect on the model
  end type correction_candidate

contains

  subroutine list_candidates(scene, candidates)
    !! List the corrections possible for a scene, with ranges that matter to its beam.
    type(scene_type), intent(in) :: scene
    type(correction_candidate), allocatable, intent(out) :: candidates(:)
    type(correction_candidate) :: candidate
    logical :: possible
    integer :: i
    allocate (candidates(0))
    do i = 1, size(correction_table)
      call fit_to_scene(correction_table(i), scene, candidate, possible)
      if (possible) candidates = [candidates, candidate]
    end do
  end subroutine list_candidates

  subroutine fit_to_scene(correction, scene, candidate, possible)
    !! Scale a correction to a scene.
    type(correction_type), intent(in) :: correction
    type(scene_type), intent(in) :: scene
    type(correction_candidate), intent(out) :: candidate
    logical, intent(out) :: possible             !! the scene can have it
    integer, allocatable :: places(:)
    type(string), allocatable :: names(:)
    real(dp) :: now(2)
    integer :: i
    candidate%effect = correction%words
    candidate%group = correction%group
    candidate%values = correction%values
    names = words_of(correction%unknown)
    do i = 1, size(names)
      candidate%unknown(i) = names(i)%text
    end do
    if (correction%kind == toggled) call toggle(scene, candidate)
    places = positions_of(scene%groups, candidate%group)
    candidate%place = candidate%group
    if (candidate%group == 'body') candidate%place = 'body(1)'
    now = 0.0_dp
    do i = 1, size(names)
      if (size(places) > 0) now(i) = scene%groups(places(1))%number(names(i)%text)
      associate (unit => own_size(name_table(name_row(candidate%group, candidate%unknown(i)))%unit, scene%beam))
        candidate%first(i) = correction%first(i)*unit
        candidate%last(i) = correction%last(i)*unit
      end associate
    end do
    select case (correction%kind)
    case (added)
      candidate%neutral = [merge(candidate%last(1), candidate%first(1), correction%neutral_at_last), candidate%last(2)]
      candidate%added = size(places) == 0
      possible = candidate%added
      if (candidate%group == 'body') then
        candidate%place = 'body('//text_of(size(places) + 1)//')'
        candidate%added = .true.
        possible = .true.
      else if (size(places) > 0 .and. candidate%unknown(1) /= '') then
        possible = .not. scene%groups(places(1))%known(trim(candidate%unknown(1)))
      end if
    case (given)
      candidate%neutral = now
      possible = size(places) > 0
      if (correction%factor > 0.0_dp) then
        candidate%first(1) = abs(now(1))/correction%factor
        candidate%last(1) = abs(now(1))*correction%factor
        candidate%neutral(1) = abs(now(1))
        possible = possible .and. abs(now(1)) > 0.0_dp
      end if
    case default
      possible = size(places) > 0
    end select
  end subroutine fit_to_scene

  pure subroutine toggle(scene, candidate)
    !! Toggle an effect defined by a value.
    type(scene_type), intent(in) :: scene
    type(correction_candidate), intent(inout) :: candidate
    character(:), allocatable :: text, value
    associate (effect => effect_table(effect_number(candidate%group)))
      text = resolved_text(scene)
      candidate%group = effect%groups
      value = trim(effect%off)
      if (has_group(text, trim(effect%groups))) then
        if (with_value(text, trim(effect%groups), trim(effect%input), value) == text) value = trim(effect%on)
      end if
      candidate%values = trim(effect%input)//' = '//value
    end associate
  end subroutine toggle

  subroutine apply_correction(candidate, measured, variant, possible)
    !! Put a correction into all scenes, if all allow it.
    type(correction_candidate), intent(in) :: candidate
    type(measured_scene), intent(in) :: measured(:)
    type(measured_scene), allocatable, intent(out) :: variant(:)
    logical, intent(out) :: possible
    character(:), allocatable :: text
    type(error_type), allocatable :: error
    integer :: i
    possible = .true.
    allocate (variant(size(measured)))
    do i = 1, size(measured)
      text = resolved_text(measured(i)%scene)
      if (candidate%group == 'body') possible = candidate%added .or. has_group(text, 'body')
      if (candidate%group /= 'body') possible = candidate%added .neqv. has_group(text, trim(candidate%group))
      if (.not. possible) return
      text = changed(candidate, text)
      if (i == 1) text = text//unknowns_text(candidate)
      call read_scene_text(text, measured(i)%scene%file, variant(i)%scene, error)
      possible = .not. allocated(error)
      if (.not. possible) return
      variant(i)%lines = measured(i)%lines
      variant(i)%monitor => measured(i)%monitor
    end do
  end subroutine apply_correction

  function changed(candidate, text) result(edited)
    !! Return a scene's text with the group or the values. The value of an unknown is arbitrary, but it must be present.
    type(correction_candidate), intent(in) :: candidate
    character(*), intent(in) :: text
    character(:), allocatable :: edited, values
    integer :: i, mark
    if (candidate%added) then
      values = ''
      if (candidate%values /= '') values = '  '//trim(candidate%values)//nl
      do i = 1, count(candidate%unknown /= '')
        values = values//'  '//trim(candidate%unknown(i))//' = '//text_of(candidate%last(i))//nl
      end do
      edited = text
      if (candidate%place == 'body(2)') edited = first_body_numbered(text)
      edited = edited//'&'//trim(candidate%group)//nl//values//'/'//nl
    else
      edited = text
      mark = index(candidate%values, ' = ')
      if (mark > 0) edited = with_value(text, trim(candidate%group), candidate%values(:mark - 1), trim(candidate%values(mark + 3:)))
      do i = 1, count(candidate%unknown /= '')
        edited = with_value(edited, trim(candidate%group), trim(candidate%unknown(i)), text_of(candidate%last(i)))
      end do
    end if
  end function changed

  pure function first_body_numbered(text) result(edited)
    !! Number the only body 1, since a second follows.
    character(*), intent(in) :: text
    character(:), allocatable :: edited
    character(*), parameter :: only = '''body%', first = '''body(1)%'
    integer :: i
    edited = text
    do
      i = index(edited, only)
      if (i == 0) return
      edited = edited(:i - 1)//first//edited(i + len(only):)
    end do
  end function first_body_numbered

  pure function unknowns_text(candidate) result(text)
    !! Return its `&identify` groups.
    type(correction_candidate), intent(in) :: candidate
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(candidate%unknown)
      if (candidate%unknown(i) == '') cycle
      text = text//'&identify'//nl//"  parameter = '"//trim(candidate%place)//'%'//trim(candidate%unknown(i))//"'"//nl// &
        '  first = '//text_of(candidate%first(i))//nl//'  last = '//text_of(candidate%last(i))//nl//'/'//nl
    end do
  end function unknowns_text

end module bw_correction_candidates
