module bw_identified_scene
  !! The scene of an identified beam, as text that runs: the fitted numbers stand in their places, and what was measured is left
  !! out (`&record`, `&spectrum`, `&identify`), so that it simulates.
  use bw_descriptors, only: close_file, flush_file, new_file, open_file, write_text
  use bw_error, only: error_type
  use bw_file_lock, only: unique_name
  use bw_files, only: cannot_be_written, directory_of, remove_file, rename_file
  use bw_fit_problem, only: value_at
  use bw_identification, only: identification
  use bw_identify_par, only: identify_par
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_unknowns, only: scene_with, with_unknowns
  use bw_scene_variant, only: without_group
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: identified_text, write_identified

contains

  function identified_text(scene, unknowns, found) result(text)
    !! The text, with a line of comment for each unknown.
    type(scene_type), intent(in) :: scene                !! without sweeps
    type(identify_par), intent(in) :: unknowns(:)        !! as they stand in it; of group 0 where it does not have them
    type(identification), intent(in) :: found
    character(:), allocatable :: text
    character, parameter :: nl = new_line('a')
    type(scene_type) :: varied, one
    type(error_type), allocatable :: error
    integer :: i
    call with_unknowns(scene, unknowns, varied)
    call scene_with(varied, found%values, one, error)
    text = resolved_text(one)
    text = without_group(text, 'record')
    text = without_group(text, 'spectrum')
    text = without_group(text, 'identify')
    do i = size(unknowns), 1, -1
      if (unknowns(i)%group == 0) cycle
      text = '! '//unknowns(i)%parameter//' = '//text_of(found%values(i))//': '//shortest(found%low(i), 6)//' to '// &
        shortest(found%high(i), 6)//nl//text
    end do
    text = '! Identified from the record of '//scene%file//'; intervals as said there.'//nl//text
  end function identified_text

  subroutine write_identified(path, text, error)
    !! Write a file under another name, and give it its own; what was there is replaced.
    !! **Errors**: `status_bad_file` where it cannot be written.
    character(*), intent(in) :: path, text
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: draft
    integer :: unit, problem, closed, ignored
    draft = directory_of(path)//'/.'//unique_name()
    problem = open_file(draft, new_file, unit)
    if (problem == 0) problem = write_text(unit, text)
    if (problem == 0) problem = flush_file(unit)
    closed = close_file(unit)
    if (problem == 0) problem = closed
    if (problem == 0) problem = rename_file(draft, path)
    if (problem == 0) return
    ignored = remove_file(draft)
    call cannot_be_written(error, path, problem)
  end subroutine write_identified

end module bw_identified_scene
