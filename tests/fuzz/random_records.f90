module random_records
  !! Files of histories as nobody should write them: tables of text and NetCDF files, by a grammar that makes each part of a file
  !! odd now and then, and by changing bytes of what comes of it.
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_ptr, c_size_t
  use bw_kinds, only: dp
  use bw_text, only: text_builder, text_of
  use netcdf, only: nf90_64bit_data, nf90_64bit_offset, nf90_byte, nf90_char, nf90_classic_model, nf90_clobber, nf90_close, &
    nf90_create, nf90_def_var, nf90_def_var_deflate, nf90_double, nf90_enddef, nf90_float, nf90_int, nf90_int64, nf90_netcdf4, &
    nf90_noerr, nf90_put_att, nf90_put_var, nf90_short, nf90_ubyte
  use random_streams, only: random_stream
  implicit none (type, external)
  private
  public :: damage_bytes, odd_table, random_names, write_odd_netcdf

  character(*), parameter :: nl = new_line('a'), tab = achar(9), cr = achar(13)
  character(*), parameter :: units(*) = [character(16) :: 's', 'ms', 'm', 'mm', 'g', 'mg', 'N', 'V', 'in/s^2', 'm s-2', 'mm/s²', &
    'm//s', '/', '1', '', 'm^', 'm^99999', 's^-', '-', '((', 'µε', 'days since 1970', char(181)//'m', '2', 'm/m/m/m/m/m']
  character(*), parameter :: names(*) = [character(16) :: 'time', 't', 'Time [s]', 'Zeit/ms', 'time_s', 'a', 'b c', 'acc (g)', &
    'F [N]', '', '"x', "'", 'a', '[]', '][', '(', 'x)', 'NaN', '1', 'displacement', 'quantity']
  character(*), parameter :: numbers(*) = [character(16) :: 'nan', 'inf', '-', '', '1e999', '1e-999', '0x10', '1,5', '1.234,5', &
    '.', '-.', '+', '1d', '--1', '"1"', '"1', "'2'", '1e+', '1 2', 'e5', '12:30:00', '2020-01-01', '1e308', '-1e308', &
    '4.9e-324', '#']
  character(*), parameter :: usual_names(*) = [character(16) :: 'displacement', 'point_position', 'recorded', 'fitted']
  integer, parameter :: types(*) = [nf90_double, nf90_double, nf90_double, nf90_float, nf90_int, nf90_short, nf90_byte, nf90_char]
  integer, parameter :: more_types(*) = [nf90_int64, nf90_ubyte]

  interface
    integer(c_int) function nc_def_dim(file, name, length, id) bind(c)
      import :: c_char, c_int, c_size_t
      implicit none (type, external)
      integer(c_int), value :: file
      character(c_char), intent(in) :: name(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(out) :: id
    end function nc_def_dim
    integer(c_int) function nc_put_att_string(file, variable, name, count, texts) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      implicit none (type, external)
      integer(c_int), value :: file, variable
      character(c_char), intent(in) :: name(*)
      integer(c_size_t), value :: count
      type(c_ptr), intent(in) :: texts(*)
    end function nc_put_att_string
  end interface

contains

  function pick(random, words) result(word)
    !! One of some words.
    type(random_stream), intent(inout) :: random
    character(*), intent(in) :: words(:)
    character(:), allocatable :: word
    word = trim(words(1 + random%below(size(words))))
  end function pick

  function random_names(random) result(text)
    !! What stands in `&record` beside the file.
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: text
    text = ''
    if (random%chance(30)) text = text//' time = 1'
    if (random%chance(25)) text = ' sample_rate = 1000'
    if (random%chance(20)) text = text//' columns = 2'
    if (random%chance(10)) text = text//" quantity = 'acceleration'"
    if (random%chance(10)) text = text//' scale = '//text_of(random%real_bits(-1020, 1020))
    if (random%chance(10)) text = text//' start = 0.005'
    if (random%chance(10)) text = text//' end = 0.02'
  end function random_names

  function odd_table(random, sound) result(text)
    !! A table of text, with an odd number, name, row or separator now and then.
    type(random_stream), intent(inout) :: random
    logical, intent(in) :: sound                           !! nothing is odd but the line of names
    character(:), allocatable :: text
    type(text_builder) :: lines
    character(:), allocatable :: separator, ending, cell
    integer :: rows, columns, odd, r, c
    character(1), parameter :: separators(4) = [',', ';', ' ', tab]
    separator = separators(1 + random%below(4))
    ending = nl
    if (random%chance(10)) ending = cr//nl
    if (random%chance(3) .and. .not. sound) ending = cr
    rows = 16 + random%below(60)
    columns = 1 + random%below(5)
    if (random%chance(5)) columns = 1 + random%below(3000)
    if (random%chance(5) .and. .not. sound) rows = random%below(4)
    odd = 0                                                ! cells of a hundred thousand
    if (random%chance(50)) odd = merge(0, 10**random%below(5), sound)
    if (sound) call put_row(names)
    do r = 1, merge(0, random%below(4), sound)
      select case (random%below(4))
      case (0); call lines%append('# '//pick(random, names)//ending)
      case (1); call put_row(names)
      case (2); call put_row(units)
      case default; call lines%append(repeat(pick(random, names)//separator, random%below(6))//ending)
      end select
    end do
    do r = 1, rows
      do c = 1, columns
        cell = text_of(random%between(-1.0_dp, 1.0_dp))
        if (c == 1) cell = text_of(real(r, dp)/1024)
        if (random%below(100000) < 10*odd .and. c == 1) cell = text_of(random%log_between(1.0e-9_dp, 1.0e15_dp))
        if (random%below(100000) < odd) cell = pick(random, numbers)
        call lines%append(cell)
        if (c < columns) call lines%append(separator)
      end do
      if (random%below(100000) < odd) call lines%append(separator//pick(random, numbers))
      if (random%below(100000) < odd) call lines%append(ending//'#'//pick(random, names))
      call lines%append(ending)
    end do
    text = lines%text()
  contains
    subroutine put_row(words)
      character(*), intent(in) :: words(:)
      integer :: k
      do k = 1, columns
        if (sound .and. k == 1) then
          call lines%append('time')
        else
          call lines%append(pick(random, words))
        end if
        if (k < columns) call lines%append(separator)
      end do
      call lines%append(ending)
    end subroutine put_row
  end function odd_table

  subroutine damage_bytes(random, text)
    !! A few bytes changed, cut out, put in or doubled, most of them near the beginning.
    type(random_stream), intent(inout) :: random
    character(:), allocatable, intent(inout) :: text
    integer :: i, at, n
    do i = 1, 1 + random%below(4)
      if (len(text) < 32) return
      at = len(text) - 24
      if (random%chance(60)) at = min(at, 4096)
      at = 1 + random%below(at)
      n = min(len(text) - at, random%below(24))
      select case (random%below(9))
      case (0:2); text(at:at) = char(random%below(256))
      case (3); text(at:at) = char(ieor(ichar(text(at:at)), 2**random%below(8)))
      case (4); text(at:at + n) = repeat(char(255), n + 1)
      case (5); text(at:at + n) = repeat(char(0), n + 1)
      case (6); text = text(:at)//text(at + n:)
      case (7); text = text(:at + n)//text(at + 1:)
      case default; if (random%chance(20)) text = text(:at)
      end select
    end do
  end subroutine damage_bytes

  subroutine write_odd_netcdf(random, path)
    !! A NetCDF file of any format, with an odd dimension, type or attribute now and then.
    type(random_stream), intent(inout) :: random
    character(*), intent(in) :: path
    integer, parameter :: formats(*) = [0, nf90_64bit_offset, nf90_64bit_data, nf90_netcdf4, nf90_netcdf4, &
                                        nf90_netcdf4 + nf90_classic_model]
    integer :: file, form, variables, v, status, format
    integer(c_int) :: dimensions(3)
    integer(c_size_t) :: lengths(3)
    format = random%below(size(formats)) + 1
    form = formats(format)
    status = nf90_create(path, ior(form, nf90_clobber), file)
    lengths = [int(16 + random%below(100), c_size_t), int(1 + random%below(4), c_size_t), int(1 + random%below(30), c_size_t)]
    if (random%chance(5)) lengths(1 + random%below(3)) = int(random%log_between(1.0_dp, 1.0e5_dp), c_size_t)
    if (random%chance(5) .and. form >= nf90_netcdf4) &         ! others would be as long
      lengths(1 + random%below(3)) = int(random%log_between(1.0e10_dp, 1.0e18_dp), c_size_t)
    if (random%chance(5)) lengths(1 + random%below(3)) = 0                        ! without limit
    status = nc_def_dim(file, trim(merge('time  ', 'frames', random%chance(80)))//c_null_char, lengths(1), dimensions(1))
    status = nc_def_dim(file, 'point'//c_null_char, lengths(2), dimensions(2))
    status = nc_def_dim(file, 'other'//c_null_char, lengths(3), dimensions(3))
    variables = 1 + random%below(4)
    do v = 1, variables
      call add_variable(random, file, v, form == nf90_netcdf4, int(dimensions) + 1)
    end do
    status = nf90_enddef(file)
    do v = 1, merge(variables, 0, maxval(lengths) <= 100000)       ! of a huge one nothing is written: the file stays small
      call fill(random, file, v, min(lengths, 1000_c_size_t))
    end do
    status = nf90_close(file)
  end subroutine write_odd_netcdf

  subroutine add_variable(random, file, number, is_enhanced, dimensions)
    !! One more variable: the first is mostly the time.
    type(random_stream), intent(inout) :: random
    integer, intent(in) :: file, number
    logical, intent(in) :: is_enhanced                     !! strings and compression may be
    integer, intent(in) :: dimensions(3)                   !! those of the file: samples, points, others
    character(:), allocatable :: name
    integer :: id, type, status, i
    name = pick(random, names)//text_of(number)
    if (random%chance(90) .and. number == 1) name = 'time'
    if (random%chance(60) .and. number == 2) name = pick(random, usual_names)
    type = types(1 + random%below(size(types)))
    if (random%chance(10) .and. is_enhanced) type = more_types(1 + random%below(2))
    if (number == 1) type = nf90_double
    status = nf90_noerr
    select case (random%below(8) + merge(8, 0, number > 1))
    case (0:11); status = nf90_def_var(file, name, type, dimensions(:1), id)
    case (12, 13); status = nf90_def_var(file, name, type, dimensions([2, 1]), id)
    case (14); status = nf90_def_var(file, name, type, dimensions([1, 2]), id)
    case default
      i = random%below(4)
      if (i == 0) status = nf90_def_var(file, name, type, dimensions([1, 1]), id)
      if (i == 1) status = nf90_def_var(file, name, type, dimensions, id)
      if (i == 2) status = nf90_def_var(file, name, type, dimensions(2:2), id)
      if (i == 3) status = nf90_def_var(file, name, type, id)
    end select
    if (status /= nf90_noerr) return
    if (random%chance(20) .and. is_enhanced) status = nf90_def_var_deflate(file, id, 1, 1, 1)
    if (random%chance(60)) call put_odd_text(random, file, id, 'units', is_enhanced)
    if (random%chance(10)) call put_odd_text(random, file, id, 'quantity', is_enhanced)
    if (random%chance(10)) call put_odd_number(random, file, id, 'scale_factor', is_enhanced)
    if (random%chance(10)) call put_odd_number(random, file, id, 'add_offset', is_enhanced)
    if (random%chance(10)) call put_odd_number(random, file, id, 'position', is_enhanced)
    if (random%chance(10)) call put_odd_number(random, file, id, 'missing_value', is_enhanced)
    if (random%chance(10)) status = nf90_put_att(file, id, '_FillValue', random%between(-1.0_dp, 1.0_dp))
  end subroutine add_variable

  subroutine put_odd_text(random, file, id, name, is_enhanced)
    !! A text as letters or as a string, or something else.
    type(random_stream), intent(inout) :: random
    integer, intent(in) :: file, id
    character(*), intent(in) :: name
    logical, intent(in) :: is_enhanced
    character(:), allocatable, target :: text
    integer :: status, count
    text = pick(random, units)
    if (random%chance(5)) text = repeat(text//'x', 1 + random%below(10000))
    if (random%chance(5)) text = text//c_null_char//'y'
    if (random%chance(10)) then
      call put_odd_number(random, file, id, name, .false.)
    else if (random%chance(50) .and. is_enhanced) then
      text = text//c_null_char
      count = merge(1, random%below(4), random%chance(80))
      status = nc_put_att_string(int(file, c_int), int(id - 1, c_int), name//c_null_char, int(count, c_size_t), &
                                 [c_loc(text), c_loc(text), c_loc(text), c_loc(text)])
    else
      status = nf90_put_att(file, id, name, text)
    end if
  end subroutine put_odd_text

  subroutine put_odd_number(random, file, id, name, is_enhanced)
    !! A number, or several, or none, or a text.
    type(random_stream), intent(inout) :: random
    integer, intent(in) :: file, id
    character(*), intent(in) :: name
    logical, intent(in) :: is_enhanced
    integer :: status, i, count
    count = 1
    if (random%chance(50)) count = random%below(merge(10000, 5, random%chance(5)))
    select case (random%below(10))
    case (0); status = nf90_put_att(file, id, name, '3')
    case (1); status = nf90_put_att(file, id, name, [(i, i=1, count)])
    case (2); if (is_enhanced) call put_odd_text(random, file, id, name, .true.)
    case (3); status = nf90_put_att(file, id, name, [(random%real_bits(-1020, 1020), i=1, count)])
    case default; status = nf90_put_att(file, id, name, [(random%between(0.0_dp, 1.0_dp), i=1, count)])
    end select
  end subroutine put_odd_number

  subroutine fill(random, file, id, lengths)
    !! Numbers of a variable: times rise, mostly; some are left as they are.
    type(random_stream), intent(inout) :: random
    integer, intent(in) :: file, id
    integer(c_size_t), intent(in) :: lengths(3)
    real(dp) :: values(lengths(1))
    integer :: i, status
    if (random%chance(5)) return
    if (size(values) == 0) return                          ! such a dimension is unlimited, and may be long by now
    do i = 1, size(values)
      values(i) = random%between(-1.0_dp, 1.0_dp)
      if (id == 1) values(i) = real(i, dp)/1024
      if (random%below(3000) == 0) values(i) = random%real_bits(-1020, 1020)
    end do
    status = nf90_put_var(file, id, values)
    if (status /= nf90_noerr) then                         ! it has more dimensions
      do i = 1, int(lengths(2))
        status = nf90_put_var(file, id, values, [1, i], [size(values), 1])
        status = nf90_put_var(file, id, values, [i, 1], [1, size(values)])
      end do
    end if
  end subroutine fill

end module random_records
