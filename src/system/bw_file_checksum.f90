module bw_file_checksum
  !! A sum of a file's bytes, by which a result knows whether a file that it was made of is still the same.
  use bw_checksum, only: lane_sums, word_sum
  use bw_descriptors, only: close_file, open_regular, read_bytes
  use bw_error, only: error_type
  use bw_files, only: cannot_be_read
  use bw_kinds, only: i1, i8
  implicit none (type, external)
  private
  public :: file_digits

  integer, parameter :: at_once = 2**20           !! bytes that are read at a time

contains

  function file_digits(path, error) result(digits)
    !! The sum of a file in hexadecimal digits. **Errors**: `status_bad_file` where it cannot be read.
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    character(16) :: digits
    write (digits, '(z16.16)') file_checksum(path, error)
  end function file_digits

  integer(i8) function file_checksum(path, error) result(total)
    !! The sum of a file's bytes and of their number; about as quick as reading them.
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    integer(i1), allocatable :: bytes(:)
    integer(i8) :: place, have
    integer :: descriptor, problem, ignored
    allocate (bytes(at_once))
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
    total = word_sum([total, place])
    ignored = close_file(descriptor)
    if (problem /= 0) call cannot_be_read(error, path, problem)
  end function file_checksum

end module bw_file_checksum
