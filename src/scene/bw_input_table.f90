module bw_input_table
  !! The table of input names: all groups and all their rows, in the order in which they are shown.
  !! A new group is one file in `groups/`, its line in each of the two lists here, and its component in `bw_scene`.
  use bw_beam_par, only: beam_group, beam_names
  use bw_capture_par, only: capture_group, capture_names
  use bw_damping_par, only: damping_group, damping_names
  use bw_impact_par, only: impact_group, impact_names
  use bw_input_name, only: input_group, input_name, name_length
  use bw_modes_par, only: modes_group, modes_names
  use bw_recontact_par, only: recontact_group, recontact_names
  use bw_release_par, only: release_group, release_names
  use bw_response_par, only: response_group, response_names
  use bw_rotation_par, only: rotation_group, rotation_names
  use bw_scene_par, only: scene_group, scene_names
  use bw_shear_par, only: shear_group, shear_names
  use bw_spectrum_par, only: spectrum_group, spectrum_names
  use bw_stiffening_par, only: stiffening_group, stiffening_names
  use bw_sweep_par, only: sweep_group, sweep_names
  implicit none (type, external)
  private
  public :: group_row, name_row, rows_of, names_of

  type(input_group), parameter, public :: group_table(*) = [ &
    scene_group, &
    beam_group, &
    rotation_group, &
    stiffening_group, &
    shear_group, &
    damping_group, &
    impact_group, &
    capture_group, &
    release_group, &
    recontact_group, &
    modes_group, &
    response_group, &
    spectrum_group, &
    sweep_group]

  type(input_name), parameter, public :: name_table(*) = [ &
    scene_names, &
    beam_names, &
    rotation_names, &
    stiffening_names, &
    shear_names, &
    damping_names, &
    impact_names, &
    capture_names, &
    release_names, &
    recontact_names, &
    modes_names, &
    response_names, &
    spectrum_names, &
    sweep_names]

contains

  pure integer function group_row(group)
    !! Place of a group in `group_table`; 0 for an unknown one.
    character(*), intent(in) :: group
    do group_row = size(group_table), 1, -1
      if (group_table(group_row)%name == group) return
    end do
  end function group_row

  pure integer function name_row(group, name)
    !! Place of a name in `name_table`; 0 for an unknown one.
    character(*), intent(in) :: group, name
    do name_row = size(name_table), 1, -1
      if (name_table(name_row)%group == group .and. name_table(name_row)%name == name) return
    end do
  end function name_row

  pure function rows_of(group) result(rows)
    !! Places of a group's rows in `name_table`, (n).
    character(*), intent(in) :: group
    integer, allocatable :: rows(:)
    integer :: i
    rows = pack([(i, i=1, size(name_table))], name_table%group == group)
  end function rows_of

  pure function names_of(group) result(names)
    !! The names of a group, (n).
    character(*), intent(in) :: group
    character(name_length), allocatable :: names(:)
    names = pack(name_table%name, name_table%group == group)
  end function names_of

end module bw_input_table
