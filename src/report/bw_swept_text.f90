module bw_swept_text
  !! The swept values of a case, in words.
  use bw_kinds, only: i8
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_positions
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: swept_text

  integer, parameter :: most_columns = 4    !! of a design whose values are shown

contains

  function swept_text(scene, i) result(text)
    !! Return the swept values of a case: 'name = value, …'; a record's file by its name; of a design with many columns
    !! the first, and its line in the table.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(in) :: i
    character(:), allocatable :: text
    integer :: positions(size(scene%sweeps)), s
    positions = case_positions(scene, i)
    text = ''
    do s = 1, size(scene%sweeps)
      if (scene%sweeps(s)%designed .and. count(scene%sweeps(:s)%designed) > most_columns) cycle
      if (text /= '') text = text//', '
      if (scene%sweeps(s)%parameter == 'record%file') then
        text = text//scene%record%files(positions(s))%text
      else
        text = text//scene%sweeps(s)%parameter//' = '//shortest(scene%sweeps(s)%values(positions(s)), 6)
      end if
    end do
    if (count(scene%sweeps%designed) <= most_columns) return
    text = text//', ... (line '//text_of(scene%design%lines(positions(1)))//')'
  end function swept_text

end module bw_swept_text
