module bw_small_file
  !! A small text file that is there as a whole or not at all.
  use bw_error, only: error_type
  use bw_file_lock, only: unique_name
  use bw_files, only: cannot_be_written, directory_of, remove_file, rename_file
  implicit none (type, external)
  private
  public :: write_small_file

contains

  subroutine write_small_file(path, text, error)
    !! Write a file under another name, and give it its own; what was there is replaced.
    !! **Errors**: `status_bad_file` where it cannot be written.
    character(*), intent(in) :: path, text
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: draft
    integer :: unit, problem, ignored
    draft = directory_of(path)//'/.'//unique_name()
    open (newunit=unit, file=draft, access='stream', form='unformatted', action='write', status='new', iostat=problem)
    if (problem == 0) write (unit, iostat=problem) text
    if (problem == 0) flush (unit, iostat=problem)
    if (problem == 0) close (unit, iostat=problem)
    if (problem == 0) problem = rename_file(draft, path)
    if (problem == 0) return
    ignored = remove_file(draft)
    call cannot_be_written(error, path, problem)
  end subroutine write_small_file

end module bw_small_file
