module record_files
  !! Files of histories that a test writes, and what is read of them.
  use bw_error, only: error_type
  use bw_files, only: remove_file
  use bw_read_record, only: read_record
  use bw_record, only: record_type
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  implicit none (type, external)
  private
  public :: read_it, refusal, write_text

  character, parameter, public :: nl = new_line('a')
  character(*), parameter, public :: file = 'test_record.scratch'

contains

  subroutine write_text(text)
    !! The file, byte by byte.
    character(*), intent(in) :: text
    integer :: unit
    open (newunit=unit, file=file, access='stream', form='unformatted', status='replace')
    write (unit) text
    close (unit)
  end subroutine write_text

  subroutine read_it(names, record, error)
    !! What a scene makes of the file; names beside `file` stand in its group.
    character(*), intent(in) :: names
    type(record_type), intent(out) :: record
    type(error_type), allocatable, intent(out) :: error
    type(scene_type) :: scene
    call read_scene_text('&spectrum /'//nl//"&record file = '"//file//"'"//nl//names//' /', 'x.nml', scene, error)
    if (.not. allocated(error)) call read_record(scene, 1, record, error)
  end subroutine read_it

  function refusal(text, names) result(message)
    !! Why a text is refused; empty if it is not.
    character(*), intent(in) :: text, names
    character(:), allocatable :: message
    type(record_type) :: record
    type(error_type), allocatable :: error
    integer :: ignored
    call write_text(text)
    call read_it(names, record, error)
    message = ''
    if (allocated(error)) message = error%message
    ignored = remove_file(file)
  end function refusal

end module record_files
