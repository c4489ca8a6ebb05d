module bw_file_checksum
  !! Checksums of files, by which a result detects that its input has changed.
  use bw_checksum, only: lane_sums, word_sum
  use bw_descriptors, only: close_file, open_regular, read_bytes
  use bw_error, only: error_type
  use bw_files, only: cannot_be_read
  use bw_kinds, only: i1, i8
  implicit none (type, external)
  private
  public :: file_digits

  integer, parameter :: at_once = 2**20           !! bytes read at a time

contains

  function file_digits(path, error) result(digits)
    !! Return the checksum of a file's bytes and length in hexadecimal; about as fast as reading it.
    !! **Errors**: `status_bad_file` if it cannot be read; then the digits are 0.
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    character(16) :: digits
    integer(i1), allocatable :: bytes(:)
    integer(i8) :: place, have, total
    integer :: descriptor, problem, ignored
    allocate (bytes(at_once))
    digits = repeat('0', len(digits))
    total = 0
    place = 0
    call open_regular(path, descriptor, error)
    if (allocated(error)) return
    do
      bytes = 0_i1
      problem = read_bytes(descriptor, place, bytes, have)
      if (problem /= 0 .or. have == 0) exit
      total = word_sum([total, lane_sums(transfer(bytes, 0_i8, at_once/8))])
      place = place + have
    end do
    write (digits, '(z16.16)') word_sum([total, place])
    ignored = close_file(descriptor)
    if (problem /= 0) call cannot_be_read(error, path, problem)
  end function file_digits

end module bw_file_checksum
