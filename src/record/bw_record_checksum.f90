module bw_record_checksum
  !! Checksums of a record's files, by which a result detects that they have changed.
  use bw_error, only: error_type
  use bw_file_checksum, only: file_digits
  use bw_read_record, only: record_path
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: file_digits, record_checksums

contains

  subroutine record_checksums(scene, text, error)
    !! Return the checksums of all files of a scene's record, sixteen hexadecimal digits each, separated by blanks.
    !! **Errors**: `status_bad_file` if one cannot be read.
    type(scene_type), intent(in) :: scene         !! with a record
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    integer :: f
    text = ''
    do f = 1, size(scene%record%files)
      if (f > 1) text = text//' '
      text = text//file_digits(record_path(scene, f), error)
      if (allocated(error)) return
    end do
  end subroutine record_checksums

end module bw_record_checksum
