module bw_hdf5_offsets
  !! Where in a NetCDF-4 file the numbers of its variables lie. NetCDF does not say. The HDF5 that it has loaded does, and is
  !! asked where it is: to link one of our own might bring a second one into the process.
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_procpointer, c_int, c_int64_t, c_null_char
  use bw_kinds, only: i8
  use bw_posix, only: loaded_procedure
  implicit none (type, external)
  private
  public :: data_offsets

  integer(c_int64_t), parameter :: by_default = 0      !! H5P_DEFAULT
  integer(c_int), parameter :: read_only = 0           !! H5F_ACC_RDONLY

  abstract interface
    integer(c_int) function get_version(major, minor, release) bind(c)
      import :: c_int
      implicit none (type, external)
      integer(c_int), intent(out) :: major, minor, release
    end function get_version
    integer(c_int64_t) function open_file(path, flags, access) bind(c)
      import :: c_char, c_int, c_int64_t
      implicit none (type, external)
      character(c_char), intent(in) :: path(*)
      integer(c_int), value :: flags
      integer(c_int64_t), value :: access
    end function open_file
    integer(c_int64_t) function open_dataset(file, name, access) bind(c)
      import :: c_char, c_int64_t
      implicit none (type, external)
      integer(c_int64_t), value :: file
      character(c_char), intent(in) :: name(*)
      integer(c_int64_t), value :: access
    end function open_dataset
    integer(c_int64_t) function get_offset(dataset) bind(c)     ! haddr_t; all bits set where there is none
      import :: c_int64_t
      implicit none (type, external)
      integer(c_int64_t), value :: dataset
    end function get_offset
    integer(c_int) function close_it(what) bind(c)
      import :: c_int, c_int64_t
      implicit none (type, external)
      integer(c_int64_t), value :: what
    end function close_it
  end interface

contains

  function data_offsets(path, names) result(offsets)
    !! The byte, from 0, at which the numbers of each variable begin; −1 where that cannot be told: they are not in one piece,
    !! the variable is not there, or no HDF5 since 1.10 can be asked.
    character(*), intent(in) :: path
    character(*), intent(in) :: names(:)
    integer(i8) :: offsets(size(names))
    procedure(open_file), pointer :: open_hdf5
    procedure(close_it), pointer :: close_hdf5
    integer(c_int64_t) :: file
    integer :: i
    integer(c_int) :: ignored
    offsets = -1
    if (.not. is_known()) return
    call c_f_procpointer(loaded_procedure('H5Fopen'), open_hdf5)
    call c_f_procpointer(loaded_procedure('H5Fclose'), close_hdf5)
    file = open_hdf5(path//c_null_char, read_only, by_default)
    if (file < 0) return
    do i = 1, size(names)
      offsets(i) = offset_of(file, trim(names(i)))
    end do
    ignored = close_hdf5(file)
  end function data_offsets

  logical function is_known()
    !! The HDF5 that is loaded has what is called here, and identifiers of 64 bits.
    procedure(get_version), pointer :: version
    character(*), parameter :: needed(*) = [character(16) :: 'H5get_libversion', 'H5Fopen', 'H5Fclose', 'H5Dopen2', &
                                            'H5Dclose', 'H5Dget_offset']
    integer(c_int) :: major, minor, release, status
    integer :: i
    is_known = .false.
    do i = 1, size(needed)
      if (.not. c_associated(loaded_procedure(trim(needed(i))))) return
    end do
    call c_f_procpointer(loaded_procedure('H5get_libversion'), version)
    status = version(major, minor, release)
    is_known = status >= 0 .and. (major > 1 .or. minor >= 10)
  end function is_known

  integer(i8) function offset_of(file, name) result(offset)
    integer(c_int64_t), intent(in) :: file
    character(*), intent(in) :: name
    procedure(open_dataset), pointer :: open_it
    procedure(get_offset), pointer :: offset_in_file
    procedure(close_it), pointer :: close_dataset
    integer(c_int64_t) :: dataset
    integer(c_int) :: ignored
    call c_f_procpointer(loaded_procedure('H5Dopen2'), open_it)
    call c_f_procpointer(loaded_procedure('H5Dget_offset'), offset_in_file)
    call c_f_procpointer(loaded_procedure('H5Dclose'), close_dataset)
    offset = -1
    dataset = open_it(file, name//c_null_char, by_default)
    if (dataset < 0) return
    offset = offset_in_file(dataset)
    ignored = close_dataset(dataset)
  end function offset_of

end module bw_hdf5_offsets
