module bw_effect_pairs
  !! Two scenes for each row of the table of effects, one with it and one without, all else as in the studied scene,
  !! which is one of the two if possible. An effect that is off is tried with a value derived from the scene, stated in
  !! the row's remark.
  use bw_kinds, only: dp, qp
  use bw_beam_par, only: beam_mass, beam_par, beam_piece, pieces_of_beam
  use bw_beam_piece, only: mass_moments, stiffness_law
  use bw_effect_list, only: effect_off, effect_on, effect_row
  use bw_effect_table, only: effect_table, effect_type, of_sphere
  use bw_input_name, only: has_word
  use bw_input_table, only: group_table
  use bw_missing, only: is_missing
  use bw_modes_par, only: by_tolerance
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_variant, only: has_group, scene_variants, with_group, with_value, without_group
  use bw_text, only: replaced, string, text_of, words_of
  use bw_tried_values, only: find_values, tried_speed
  implicit none (type, external)
  private
  public :: pairs_of

  type, public :: compared_scenes
    !! All rows, and every scene they need, each once; the first is the studied one.
    type(effect_row), allocatable :: rows(:)       !! in the order of the table
    type(scene_variants) :: variants
    type(tried_speed), private :: speed
  end type compared_scenes

contains

  subroutine pairs_of(scene, list)
    !! Find the pair of scenes for each effect.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(compared_scenes), intent(out) :: list
    character(:), allocatable :: text, reason
    integer :: place, i
    text = without_group(resolved_text(scene), 'spectrum')
    if (.not. scene%modes%asked) text = with_value(text, 'modes', 'tolerance', '')    ! each variant is relaxed by itself
    list%variants%file = scene%file
    call list%variants%find(text, place, reason)   ! the studied scene was read before and is not refused here
    allocate (list%rows(size(effect_table)))
    do i = 1, size(effect_table)
      list%rows(i)%effect = effect_table(i)%name
      list%rows(i)%remark = why_not_compared(scene, text, effect_table(i))
      if (list%rows(i)%remark == '') call find_pair(scene, text, effect_table(i), list, list%rows(i))
    end do
  end subroutine pairs_of

  pure function why_not_compared(scene, text, effect) result(reason)
    !! Say why an effect cannot be compared for a scene; empty if it can.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_type), intent(in) :: effect
    character(:), allocatable :: reason
    type(string), allocatable :: excluded(:)
    integer :: i
    reason = ''
    excluded = words_of(effect%excludes)
    do i = size(excluded), 1, -1
      if (has_group(text, excluded(i)%text)) reason = 'excludes &'//excluded(i)%text
    end do
    if (reason == '' .and. any_group(text, effect%needs, is_there=.false.)) reason = 'needs &'// &
      replaced(trim(effect%needs), ' ', ' and &')
    if (effect%name == 'pieces' .and. allocated(scene%beam%outer)) reason = 'the beam tapers: see taper'
    if (effect%name == 'taper' .and. allocated(scene%beam%pieces) .and. .not. allocated(scene%beam%outer)) &
      reason = 'is tried only on a beam of one piece'
    if (reason == '' .and. effect%measure == of_sphere .and. scene%beam%is_lumped) reason = 'needs a density of the beam'
    if (reason == '' .and. effect%counted .and. has_group(text, trim(effect%groups)) .and. by_tolerance(scene%modes)) &
      reason = 'comparison with a rebound needs counts of modes, since its impulse tends to 0 as modes are added'
  end function why_not_compared

  pure logical function any_group(text, groups, is_there)
    !! Return whether any of several groups is in a text, or is absent from it.
    character(*), intent(in) :: text
    character(*), intent(in) :: groups             !! separated by blanks
    logical, intent(in) :: is_there
    type(string), allocatable :: names(:)
    integer :: i
    names = words_of(groups)
    any_group = .false.
    do i = 1, size(names)
      any_group = any_group .or. (has_group(text, names(i)%text) .eqv. is_there)
    end do
  end function any_group

  subroutine find_pair(scene, text, effect, list, row)
    !! Fill the row of an effect with its two scenes, or with the reader's first reason if one is refused.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_type), intent(in) :: effect
    type(compared_scenes), intent(inout) :: list
    type(effect_row), intent(inout) :: row
    character(:), allocatable :: with, without, reason
    if (effect%name == 'pieces' .or. effect%name == 'taper') then
      call pair_pieces(scene, text, effect, list, row, with, without)
    else if (effect%input /= '') then
      call pair_values(scene, text, effect, list, row, with, without)
    else
      call pair_groups(scene, text, effect, list, row, with, without)
    end if
    call list%variants%find(with, row%place_with, reason)
    call list%variants%find(without, row%place_without, reason)
    if (allocated(reason)) row = effect_row(effect=effect%name, remark=reason)
  end subroutine find_pair

  subroutine pair_groups(scene, text, effect, list, row, with, without)
    !! Pair the scenes of an effect defined by groups: remove them if the scene has them all, else add the missing ones.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_type), intent(in) :: effect
    type(compared_scenes), intent(inout) :: list
    type(effect_row), intent(inout) :: row
    character(:), allocatable, intent(out) :: with, without
    type(string), allocatable :: groups(:)
    character(:), allocatable :: values
    integer :: i
    with = text
    if (effect%alone) with = without_dependents(text, effect%groups)
    without = without_groups(with, effect%groups)
    row%state = effect_on
    row%remark = trim(effect%remark_on)
    if (.not. any_group(with, effect%groups, is_there=.false.)) return
    row%state = effect_off
    groups = words_of(effect%groups)
    values = trim(effect%values)
    if (has_group(with, groups(1)%text)) values = ''
    call find_values(scene, effect, list%speed, values, row%remark)
    do i = 1, size(groups)
      if (.not. has_group(with, groups(i)%text)) with = with_group(without_excluded(with, groups(i)%text), groups(i)%text, values)
      values = ''
    end do
  end subroutine pair_groups

  pure function without_groups(text, groups) result(edited)
    !! Return the text without several groups and those that depend on them.
    character(*), intent(in) :: text, groups
    character(:), allocatable :: edited
    type(string), allocatable :: names(:)
    integer :: i
    edited = without_dependents(text, groups)
    names = words_of(groups)
    do i = 1, size(names)
      edited = without_group(edited, names(i)%text)
      if (names(i)%text == 'capture') edited = with_value(edited, 'modes', 'after', '')    ! then there is one set of modes
    end do
  end function without_groups

  pure function without_dependents(text, groups) result(edited)
    !! Return the text without the groups that depend on any of several groups.
    character(*), intent(in) :: text, groups
    character(:), allocatable :: edited
    integer :: i
    edited = text
    do i = 1, size(group_table)
      if (group_table(i)%needs /= '' .and. has_word(groups, group_table(i)%needs)) &
        edited = without_group(edited, trim(group_table(i)%name))
    end do
  end function without_dependents

  pure function without_excluded(text, group) result(edited)
    !! Return the text without the groups that exclude a group.
    character(*), intent(in) :: text, group
    character(:), allocatable :: edited
    integer :: i
    edited = text
    do i = 1, size(group_table)
      if (has_word(group_table(i)%excludes, group)) edited = without_group(edited, trim(group_table(i)%name))
    end do
  end function without_excluded

  subroutine pair_values(scene, text, effect, list, row, with, without)
    !! Pair the scenes of an effect defined by the value of a name.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_type), intent(in) :: effect
    type(compared_scenes), intent(inout) :: list
    type(effect_row), intent(inout) :: row
    character(:), allocatable, intent(out) :: with, without
    character(:), allocatable :: on
    with = text
    without = with_value(text, trim(effect%groups), trim(effect%input), trim(effect%off))
    row%state = effect_on
    row%remark = trim(effect%remark_on)
    if (without /= text) return
    row%state = effect_off
    on = trim(effect%on)
    call find_values(scene, effect, list%speed, on, row%remark)
    with = with_value(text, trim(effect%groups), trim(effect%input), on)
  end subroutine pair_values

  subroutine pair_pieces(scene, text, effect, list, row, with, without)
    !! Pair a beam of several pieces, or a tapered one, with its uniform mean; pair a uniform beam with one whose outer
    !! half is softer, or whose tip is thinner.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: text
    type(effect_type), intent(in) :: effect
    type(compared_scenes), intent(inout) :: list
    type(effect_row), intent(inout) :: row
    character(:), allocatable, intent(out) :: with, without
    character(:), allocatable :: values, name
    real(dp) :: root
    with = text
    without = text
    associate (beam => scene%beam)
      if (effect%name == 'pieces' .and. beam%is_lumped) then
        name = 'bending_stiffness'
        root = beam%youngs_modulus
      else if (effect%name == 'pieces') then
        name = 'youngs_modulus'
        root = beam%youngs_modulus
      else if (beam%round) then
        name = 'diameter'
        root = beam%diameter
      else if (.not. is_missing(beam%height)) then
        name = 'height'
        root = beam%height
      else
        name = merge('bending_stiffness', 'second_moment    ', beam%is_lumped)
        root = merge(beam%youngs_modulus, beam%second_moment, beam%is_lumped)
      end if
      if (allocated(beam%pieces)) then
        row%state = effect_on
        row%remark = trim(effect%remark_on)
        without = with_group(text, 'beam', mean_beam(beam))
      else
        row%state = effect_off
        values = text_of(root)//', '//text_of(effect%tried*root)
        with = with_value(text, 'beam', trim(name), values)
        if (effect%name == 'pieces') then
          with = with_value(with, 'beam', 'length', text_of(0.5_dp*beam%length)//', '//text_of(0.5_dp*beam%length))
        else
          with = with_value(with, 'beam', 'taper', "'linear'")
        end if
        call find_values(scene, effect, list%speed, values, row%remark)
        row%remark = row%remark//repeat(' '//trim(name), merge(1, 0, effect%name == 'taper'))
      end if
    end associate
  end subroutine pair_pieces

  pure function mean_beam(beam) result(values)
    !! Return a uniform beam with the length, mass and mean bending stiffness of one with several pieces or taper.
    type(beam_par), intent(in) :: beam
    character(:), allocatable :: values
    type(beam_piece), allocatable :: inner(:), outer(:)
    real(qp) :: area, length, stiffness, second_moment, moments(2)
    real(qp), allocatable :: law(:)
    integer :: i, k
    inner = pieces_of_beam(beam)
    outer = inner
    if (allocated(beam%outer)) outer = beam%outer
    length = sum(real(inner%length, qp))
    stiffness = 0
    second_moment = 0
    area = 0
    do i = 1, size(inner)
      law = stiffness_law(inner(i), outer(i))
      stiffness = stiffness + sum([(law(k)/k, k=1, size(law))])*inner(i)%length/length
      inner(i)%density = 1
      outer(i)%density = 1
      inner(i)%youngs_modulus = 1
      outer(i)%youngs_modulus = 1
      law = stiffness_law(inner(i), outer(i))
      second_moment = second_moment + sum([(law(k)/k, k=1, size(law))])*inner(i)%length/length
      moments = mass_moments(inner(i), outer(i))
      area = area + moments(1)/length
    end do
    values = 'length = '//text_of(beam%length)
    if (beam%is_lumped) then
      values = values//', mass_per_length = '//text_of(real(beam_mass(beam)/length, dp))//', bending_stiffness = '// &
        text_of(real(stiffness, dp))
    else
      values = values//', density = '//text_of(real(beam_mass(beam)/length/area, dp))//', youngs_modulus = '// &
        text_of(real(stiffness/second_moment, dp))//', area = '//text_of(real(area, dp))//', second_moment = '// &
        text_of(real(second_moment, dp))
    end if
  end function mean_beam

end module bw_effect_pairs
