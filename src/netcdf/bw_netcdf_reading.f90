module bw_netcdf_reading
  !! Reading of any NetCDF file with 64-bit sizes by the C library, which the first call loads; netCDF-Fortran has 32
  !! bits and lacks the string type, which h5py and netCDF4 write. The type and length of an attribute are checked
  !! before it is read. Files, dimensions and variables have C's numbers, from 0; `status` is NetCDF's, 0 for success,
  !! and no call is made after an error. A file that crashes the library ends the program, which names it.
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, c_null_char, c_ptr, c_size_t
  use bw_kinds, only: dp, i8
  use bw_netcdf_path, only: plain_path
  implicit none (type, external)
  private
  public :: close_netcdf, find_variable, is_classic, open_netcdf, read_dimensions, read_number, read_numbers, read_text
  public :: read_variable, status_text

  integer, parameter, public :: all_is_well = 0
  integer, parameter, public :: no_memory = -61                        !! a status
  integer, parameter :: longest_name = 256                             !! limit of NetCDF
  integer(c_int), parameter :: no_such_attribute = -43
  integer(c_int), parameter :: of_char = 2, of_float = 5, of_string = 12, last_plain = 11      !! types
  integer, parameter :: bytes_of(last_plain) = [1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8]               !! of each type

  type, public :: netcdf_dimension
    character(:), allocatable :: name
    integer(i8) :: length = 0
  end type netcdf_dimension

  type, public :: netcdf_variable
    character(:), allocatable :: name
    integer, allocatable :: dimensions(:)        !! numbers of the file's dimensions, the fastest last
    logical :: is_numeric = .false.
    logical :: is_single = .false.               !! in single precision
    integer :: bytes = 0                         !! of a number or letter; 0 for a user-defined type
  end type netcdf_variable

  interface
    integer(c_int) function nc_open(path, mode, file) bind(c, name='bw_nc_open')
      import :: c_char, c_int
      character(c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
      integer(c_int), intent(out) :: file
    end function nc_open
    integer(c_int) function nc_close(file) bind(c, name='bw_nc_close')
      import :: c_int
      integer(c_int), value :: file
    end function nc_close
    integer(c_int) function nc_inq_format(file, format) bind(c, name='bw_nc_inq_format')
      import :: c_int
      integer(c_int), value :: file
      integer(c_int), intent(out) :: format
    end function nc_inq_format
    integer(c_int) function nc_inq(file, dimensions, variables, attributes, unlimited) bind(c, name='bw_nc_inq')
      import :: c_int
      integer(c_int), value :: file
      integer(c_int), intent(out) :: dimensions, variables, attributes, unlimited
    end function nc_inq
    integer(c_int) function nc_inq_dim(file, dimension, name, length) bind(c, name='bw_nc_inq_dim')
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: file, dimension
      character(c_char), intent(out) :: name(*)
      integer(c_size_t), intent(out) :: length
    end function nc_inq_dim
    integer(c_int) function nc_inq_varid(file, name, variable) bind(c, name='bw_nc_inq_varid')
      import :: c_char, c_int
      integer(c_int), value :: file
      character(c_char), intent(in) :: name(*)
      integer(c_int), intent(out) :: variable
    end function nc_inq_varid
    integer(c_int) function nc_inq_varndims(file, variable, rank) bind(c, name='bw_nc_inq_varndims')
      import :: c_int
      integer(c_int), value :: file, variable
      integer(c_int), intent(out) :: rank
    end function nc_inq_varndims
    integer(c_int) function nc_inq_var(file, variable, name, type, rank, dimensions, attributes) bind(c, name='bw_nc_inq_var')
      import :: c_char, c_int
      integer(c_int), value :: file, variable
      character(c_char), intent(out) :: name(*)
      integer(c_int), intent(out) :: type, rank, dimensions(*), attributes
    end function nc_inq_var
    integer(c_int) function nc_get_vara_double(file, variable, first, count, values) bind(c, name='bw_nc_get_vara_double')
      import :: c_double, c_int, c_size_t
      integer(c_int), value :: file, variable
      integer(c_size_t), intent(in) :: first(*), count(*)
      real(c_double), intent(inout) :: values(*)
    end function nc_get_vara_double
    integer(c_int) function nc_inq_att(file, variable, name, type, length) bind(c, name='bw_nc_inq_att')
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: file, variable
      character(c_char), intent(in) :: name(*)
      integer(c_int), intent(out) :: type
      integer(c_size_t), intent(out) :: length
    end function nc_inq_att
    integer(c_int) function nc_get_att_double(file, variable, name, value) bind(c, name='bw_nc_get_att_double')
      import :: c_char, c_double, c_int
      integer(c_int), value :: file, variable
      character(c_char), intent(in) :: name(*)
      real(c_double), intent(inout) :: value(*)
    end function nc_get_att_double
    integer(c_int) function nc_get_att_text(file, variable, name, text) bind(c, name='bw_nc_get_att_text')
      import :: c_char, c_int
      integer(c_int), value :: file, variable
      character(c_char), intent(in) :: name(*)
      character(c_char), intent(inout) :: text(*)
    end function nc_get_att_text
    integer(c_int) function nc_get_att_string(file, variable, name, texts) bind(c, name='bw_nc_get_att_string')
      import :: c_char, c_int, c_ptr
      integer(c_int), value :: file, variable
      character(c_char), intent(in) :: name(*)
      type(c_ptr), intent(inout) :: texts(*)
    end function nc_get_att_string
    integer(c_int) function nc_free_string(count, texts) bind(c, name='bw_nc_free_string')
      import :: c_int, c_ptr, c_size_t
      integer(c_size_t), value :: count
      type(c_ptr), intent(inout) :: texts(*)
    end function nc_free_string
    type(c_ptr) function nc_strerror(status) bind(c, name='bw_nc_strerror')
      import :: c_int, c_ptr
      integer(c_int), value :: status
    end function nc_strerror
    pure integer(c_size_t) function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function strlen
  end interface

contains

  subroutine open_netcdf(path, file, status)
    !! Open a file to read.
    character(*), intent(in) :: path             !! without backslash, see `has_backslash`
    integer, intent(out) :: file                 !! below 0 if it cannot be opened
    integer, intent(out) :: status
    integer(c_int) :: opened
    status = int(nc_open(plain_path(path), 0_c_int, opened))
    file = -1
    if (status == all_is_well) file = int(opened)
  end subroutine open_netcdf

  subroutine close_netcdf(file)
    !! Close a file, if it was opened.
    integer, intent(in) :: file
    integer(c_int) :: ignored
    if (file >= 0) ignored = nc_close(int(file, c_int))
  end subroutine close_netcdf

  logical function is_classic(file)
    !! Return whether a file has a format before HDF5, which does not reveal truncation.
    integer, intent(in) :: file
    integer(c_int) :: format
    is_classic = .false.
    if (nc_inq_format(int(file, c_int), format) == all_is_well) is_classic = any(format == [1, 2, 5])
  end function is_classic

  function status_text(status) result(text)
    !! Return the library's message for a status.
    integer, intent(in) :: status
    character(:), allocatable :: text
    text = c_text(nc_strerror(int(status, c_int)))
  end function status_text

  subroutine read_dimensions(file, dimensions, variables, status)
    !! Read all dimensions of a file, and allocate its variables.
    integer, intent(in) :: file
    type(netcdf_dimension), allocatable, intent(out) :: dimensions(:)
    type(netcdf_variable), allocatable, intent(out) :: variables(:)
    integer, intent(inout) :: status
    character(longest_name + 1) :: name
    integer(c_int) :: count, others, ignored(2)
    integer(c_size_t) :: length
    integer :: d
    others = 0
    count = 0
    if (status == all_is_well) status = int(nc_inq(int(file, c_int), count, others, ignored(1), ignored(2)))
    if (status /= all_is_well) count = 0
    allocate (dimensions(count), variables(merge(others, 0_c_int, status == all_is_well)))
    do d = 1, size(dimensions)
      length = 0
      if (status == all_is_well) status = int(nc_inq_dim(int(file, c_int), int(d - 1, c_int), name, length))
      if (status /= all_is_well) return
      dimensions(d) = netcdf_dimension(name(:index(name, c_null_char) - 1), int(length, i8))
    end do
  end subroutine read_dimensions

  subroutine read_variable(file, number, variable, status)
    !! Read the properties of a variable.
    integer, intent(in) :: file, number
    type(netcdf_variable), intent(out) :: variable
    integer, intent(inout) :: status
    character(longest_name + 1) :: name
    integer(c_int), allocatable :: dimensions(:)
    integer(c_int) :: type, rank, ignored
    rank = 0
    if (status == all_is_well) status = int(nc_inq_varndims(int(file, c_int), int(number, c_int), rank))
    if (status /= all_is_well) return
    allocate (dimensions(rank))
    status = int(nc_inq_var(int(file, c_int), int(number, c_int), name, type, rank, dimensions, ignored))
    if (status /= all_is_well) return
    variable = netcdf_variable(name(:index(name, c_null_char) - 1), int(dimensions), is_plain(type), type == of_float)
    if (type >= 1 .and. type <= last_plain) variable%bytes = bytes_of(type)
  end subroutine read_variable

  pure logical function is_plain(type)
    !! Return whether a type is a built-in type of numbers.
    integer(c_int), intent(in) :: type
    is_plain = type >= 1 .and. type <= last_plain .and. type /= of_char
  end function is_plain

  integer function find_variable(file, name) result(number)
    !! Return the number of a variable; below 0 if there is none.
    integer, intent(in) :: file
    character(*), intent(in) :: name
    integer(c_int) :: found
    number = -1
    if (nc_inq_varid(int(file, c_int), name//c_null_char, found) == all_is_well) number = int(found)
  end function find_variable

  subroutine read_numbers(file, variable, first, count, values, status)
    !! Read a part of a variable in double precision.
    integer, intent(in) :: file, variable
    integer(i8), intent(in) :: first(:), count(:)    !! along each dimension, from 1; the fastest last
    real(dp), intent(inout) :: values(*)         !! as many as the product of the counts
    integer, intent(inout) :: status
    if (status /= all_is_well) return
    status = int(nc_get_vara_double(int(file, c_int), int(variable, c_int), int(first - 1, c_size_t), int(count, c_size_t), &
                                    values))
  end subroutine read_numbers

  subroutine read_text(file, variable, name, text, status)
    !! Read an attribute that is one text of either type, without trailing blanks; empty if there is none.
    integer, intent(in) :: file, variable        !! −1 for an attribute of the file
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: text
    integer, intent(inout) :: status
    character(:), allocatable :: letters
    type(c_ptr) :: address(1)
    integer(c_int) :: type, ignored
    integer(c_size_t) :: length
    integer :: refused
    text = ''
    call look_at_attribute(file, variable, name, type, length, status)
    if (status /= all_is_well) return
    if (type == of_char .and. length > 0) then
      allocate (character(length) :: letters, stat=refused)
      if (refused /= 0) status = no_memory
      if (refused == 0) status = int(nc_get_att_text(int(file, c_int), int(variable, c_int), name//c_null_char, letters))
      if (status == all_is_well) text = trim(letters(:index(letters//c_null_char, c_null_char) - 1))
    else if (type == of_string .and. length == 1) then
      status = int(nc_get_att_string(int(file, c_int), int(variable, c_int), name//c_null_char, address))
      if (status /= all_is_well) return
      text = trim(c_text(address(1)))
      ignored = nc_free_string(1_c_size_t, address)
    end if
  end subroutine read_text

  subroutine read_number(file, variable, name, number, there, status)
    !! Read an attribute that is one number.
    integer, intent(in) :: file, variable
    character(*), intent(in) :: name
    real(dp), intent(inout) :: number            !! unchanged unless `there` is 1
    integer(i8), intent(out) :: there            !! its length; 0: absent; below 0: not numeric
    integer, intent(inout) :: status
    real(c_double) :: value(1)
    integer(c_int) :: type
    integer(c_size_t) :: length
    there = 0
    call look_at_attribute(file, variable, name, type, length, status)
    if (status /= all_is_well) return
    there = int(length, i8)
    if (.not. is_plain(type) .and. type /= 0) there = -1
    if (there /= 1) return
    status = int(nc_get_att_double(int(file, c_int), int(variable, c_int), name//c_null_char, value))
    number = value(1)
  end subroutine read_number

  subroutine look_at_attribute(file, variable, name, type, length, status)
    !! Get the type and length of an attribute; both 0 if it is absent.
    integer, intent(in) :: file, variable
    character(*), intent(in) :: name
    integer(c_int), intent(out) :: type
    integer(c_size_t), intent(out) :: length
    integer, intent(inout) :: status
    type = 0
    length = 0
    if (status /= all_is_well) return
    status = int(nc_inq_att(int(file, c_int), int(variable, c_int), name//c_null_char, type, length))
    if (status /= no_such_attribute) return
    status = all_is_well
    type = 0
    length = 0
  end subroutine look_at_attribute

  function c_text(address) result(text)
    !! Return a C string.
    type(c_ptr), intent(in) :: address
    character(:), allocatable :: text
    character(c_char), pointer :: letters(:)
    integer(i8) :: i
    text = ''
    if (.not. c_associated(address)) return
    deallocate (text)
    call c_f_pointer(address, letters, [strlen(address)])
    allocate (character(size(letters)) :: text)
    do i = 1, size(letters, kind=i8)
      text(i:i) = letters(i)
    end do
  end function c_text

end module bw_netcdf_reading
