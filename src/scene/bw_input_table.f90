module bw_input_table
  !! The table of input names: all groups and all their rows, in the order in which they are shown. For groups and names
  !! that are not in it, messages list the known ones and suggest the nearest.
  !! A new group is one file in `groups/`, a line in each of the two lists here, and its lines in
  !! `bw_scene` and `bw_scene_groups`.
  use bw_beam_par, only: beam_group, beam_names
  use bw_body_par, only: body_group, body_names
  use bw_capture_par, only: capture_group, capture_names
  use bw_contact_par, only: contact_group, contact_names
  use bw_damping_par, only: damping_group, damping_names
  use bw_design_par, only: design_group, design_names
  use bw_frequency_response_par, only: frequency_response_group, frequency_response_names
  use bw_hub_par, only: hub_group, hub_names
  use bw_identify_par, only: identify_group, identify_names
  use bw_initial_par, only: initial_group, initial_names
  use bw_impact_par, only: impact_group, impact_names
  use bw_input_name, only: input_group, input_name, is_sweepable, name_length
  use bw_load_par, only: base_group, base_names, force_group, force_names
  use bw_modes_par, only: modes_group, modes_names
  use bw_record_par, only: record_group, record_names
  use bw_recontact_par, only: recontact_group, recontact_names
  use bw_release_par, only: release_group, release_names
  use bw_response_par, only: response_group, response_names
  use bw_rotation_par, only: rotation_group, rotation_names
  use bw_scene_par, only: scene_group, scene_names
  use bw_shear_par, only: shear_group, shear_names
  use bw_spectrum_par, only: spectrum_group, spectrum_names
  use bw_stiffening_par, only: stiffening_group, stiffening_names
  use bw_support_par, only: support_group, support_names, tip_support_group, tip_support_names
  use bw_sweep_par, only: sweep_group, sweep_names
  use bw_text, only: joined
  implicit none (type, external)
  private
  public :: closest, group_row, name_row, rows_of, suggestion, unknown_group, unknown_name

  type(input_group), parameter, public :: group_table(*) = [ &
    scene_group, &
    beam_group, &
    support_group, &
    tip_support_group, &
    hub_group, &
    body_group, &
    rotation_group, &
    stiffening_group, &
    shear_group, &
    damping_group, &
    impact_group, &
    contact_group, &
    capture_group, &
    release_group, &
    recontact_group, &
    force_group, &
    base_group, &
    initial_group, &
    modes_group, &
    response_group, &
    frequency_response_group, &
    record_group, &
    spectrum_group, &
    identify_group, &
    design_group, &
    sweep_group]

  type(input_name), parameter, public :: name_table(*) = [ &
    scene_names, &
    beam_names, &
    support_names, &
    tip_support_names, &
    hub_names, &
    body_names, &
    rotation_names, &
    stiffening_names, &
    shear_names, &
    damping_names, &
    impact_names, &
    contact_names, &
    capture_names, &
    release_names, &
    recontact_names, &
    force_names, &
    base_names, &
    initial_names, &
    modes_names, &
    response_names, &
    frequency_response_names, &
    record_names, &
    spectrum_names, &
    identify_names, &
    design_names, &
    sweep_names]

contains

  pure integer function group_row(group)
    !! Return the place of a group in `group_table`; 0 for an unknown one.
    character(*), intent(in) :: group
    do group_row = size(group_table), 1, -1
      if (group_table(group_row)%name == group) return
    end do
  end function group_row

  pure integer function name_row(group, name)
    !! Return the place of a name in `name_table`; 0 for an unknown one.
    character(*), intent(in) :: group, name
    do name_row = size(name_table), 1, -1
      if (name_table(name_row)%group == group .and. name_table(name_row)%name == name) return
    end do
  end function name_row

  pure function rows_of(group) result(rows)
    !! Return the places of a group's rows in `name_table`, (n).
    character(*), intent(in) :: group
    integer, allocatable :: rows(:)
    integer :: i
    rows = pack([(i, i=1, size(name_table))], name_table%group == group)
  end function rows_of

  pure function unknown_group(group) result(text)
    !! Return the message for a group that is not in the table.
    character(*), intent(in) :: group
    character(:), allocatable :: text
    text = 'is not a known group'//suggestion(group, group_table%name, '&')//'; accepted: '//joined(group_table%name, '&')
  end function unknown_group

  pure function unknown_name(group, name, to_sweep) result(text)
    !! Return the message for a name that is not in its group.
    character(*), intent(in) :: group, name
    logical, intent(in), optional :: to_sweep   !! of a sweep, which accepts fewer names
    character(:), allocatable :: text
    character(name_length), allocatable :: names(:)
    names = pack(name_table%name, name_table%group == group)
    if (present(to_sweep)) names = pack(name_table%name, name_table%group == group .and. is_sweepable(name_table))
    text = suggestion(name, names, '')
    associate (elsewhere => pack(name_table%group, name_table%name == name))
      if (text == '' .and. size(elsewhere) > 0) text = ' (it belongs to '//joined(elsewhere, '&')//')'
    end associate
    if (index(name, '%') > 0) text = ' (write the group as &group and its names alone)'
    if (index(name, '(') > 0) text = ' (write the values of a list without an index, as length = 0.3, 0.7)'
    text = 'is not a known name'//text//'; accepted: '//joined(names)
    if (size(names) == 0) text = text//'none'
  end function unknown_name

  pure integer function closest(word, known)
    !! Return the place of the nearest known word, else of the first that contains the word or is contained in it; 0 for none.
    character(*), intent(in) :: word
    character(*), intent(in) :: known(:)
    integer :: i, distance, least
    closest = 0
    least = 1 + max(1, len_trim(word)/3)
    if (len_trim(word) > 2*len(known)) return
    do i = 1, size(known)
      distance = edits(trim(word), trim(known(i)))
      if (distance < least) then
        least = distance
        closest = i
      end if
    end do
    if (closest > 0) return
    do i = 1, size(known)                     ! velocity in approach_velocity, ratio in damping_ratio
      if (is_part(trim(word), trim(known(i))) .or. is_part(trim(known(i)), trim(word))) closest = i
      if (closest > 0) return
    end do
  end function closest

  pure logical function is_part(word, name)
    !! Return whether a word is the beginning or the end of a name whose parts are joined by underscores.
    character(*), intent(in) :: word, name
    is_part = .false.
    if (len(name) > len(word)) is_part = index(name, word//'_') == 1 .or. name(len(name) - len(word):) == '_'//word
  end function is_part

  pure function suggestion(word, known, before) result(text)
    !! Return ` (did you mean &beam?)`, or nothing.
    character(*), intent(in) :: word
    character(*), intent(in) :: known(:)
    character(*), intent(in) :: before        !! precedes the suggested word
    character(:), allocatable :: text
    integer :: i
    i = closest(word, known)
    text = ''
    if (i > 0) text = ' (did you mean '//before//trim(known(i))//'?)'
  end function suggestion

  pure integer function edits(a, b)
    !! Count the letters inserted, deleted, replaced or swapped with their neighbour between a and b
    !! (optimal string alignment distance).
    character(*), intent(in) :: a, b
    integer :: table(0:len(a), 0:len(b)), i, j
    table(:, 0) = [(i, i=0, len(a))]
    table(0, :) = [(j, j=0, len(b))]
    do j = 1, len(b)
      do i = 1, len(a)
        table(i, j) = min(table(i - 1, j) + 1, table(i, j - 1) + 1, &
                          table(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
        if (swapped(a(:i), b(:j))) table(i, j) = min(table(i, j), table(max(i - 2, 0), max(j - 2, 0)) + 1)
      end do
    end do
    edits = table(len(a), len(b))
  end function edits

  pure logical function swapped(a, b)
    !! Return whether a and b end in the same two letters in opposite order.
    character(*), intent(in) :: a, b
    swapped = .false.
    if (len(a) > 1 .and. len(b) > 1) swapped = a(len(a) - 1:) == b(len(b):)//b(len(b) - 1:len(b) - 1)
  end function swapped

end module bw_input_table
