program fuzz_records
  !! fuzz_records COUNT [FIRST LAST]
  !!
  !! Reads COUNT odd tables of text, as many sound ones with damaged bytes, and so many odd NetCDF files, as `beamwave check`
  !! does. Each is a record or refused with one line and a status that says so, in ten seconds of processor time and one gigabyte.
  !! Ends with 1 at the first that is not, leaves it behind, and says how to make it again. FIRST and LAST, 1 to
  !! 3, are kinds of records. BEAMWAVE_SEED sets the seed.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_status, ieee_set_halting_mode, ieee_set_status, ieee_status_type
  use, intrinsic :: iso_c_binding, only: c_int, c_long
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use bw_error, only: error_type, status_bad_file, status_bad_input
  use bw_kinds, only: dp, i8
  use bw_process, only: leave, watch_over_process
  use bw_record, only: record_extent, record_type
  use bw_record_plan, only: plan_record
  use bw_record_summary, only: record_summary
  use bw_result_layout, only: layout_of, result_layout
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use random_records, only: damage_bytes, odd_table, random_names, write_odd_netcdf
  use random_streams, only: random_stream, stream_of_environment
  implicit none (type, external)

  real(dp), parameter :: most_seconds = 10.0_dp
  integer(i8), parameter :: most_kilobytes = 1000000
  integer(c_int), parameter :: length_of_files = 1         ! RLIMIT_FSIZE
  integer(c_long), parameter :: largest_file = 200000000   ! bytes
  character(*), parameter :: file = 'fuzz_records.scratch'
  character(*), parameter :: kinds(3) = [character(32) :: 'odd tables', 'tables with damaged bytes', 'odd NetCDF files']

  interface
    integer(c_int) function getrusage(who, usage) bind(c)
      import :: c_int, c_long
      implicit none (type, external)
      integer(c_int), value :: who
      integer(c_long), intent(out) :: usage(18)            !! 1 to 4: seconds and microseconds, of two kinds; 5: kilobytes, at most
    end function getrusage
    integer(c_int) function setrlimit(what, limits) bind(c)
      import :: c_int, c_long
      implicit none (type, external)
      integer(c_int), value :: what
      integer(c_long), intent(in) :: limits(2)
    end function setrlimit
  end interface

  type(random_stream) :: random, begin
  integer :: count, kind, kinds_asked(2), i, good
  real(dp) :: slowest, spent
  character(16) :: word

  call watch_over_process()                                ! so that a fault is told
  if (setrlimit(length_of_files, [largest_file, largest_file]) /= 0) call give_up('files cannot be limited')
  call get_command_argument(1, word)
  read (word, *) count
  kinds_asked = [1, size(kinds)]
  do i = 1, 2
    call get_command_argument(1 + i, word)
    if (word /= '') read (word, *) kinds_asked(i)
  end do
  random = stream_of_environment()
  do kind = kinds_asked(1), kinds_asked(2)
    write (output_unit, '(i0,1x,3a)') count, trim(kinds(kind)), ', ', random%seed_text()
    flush (output_unit)
    good = 0
    slowest = 0.0_dp
    do i = 1, count
      begin = random
      call write_record()
      spent = processor_seconds()
      call read_it()
      spent = processor_seconds() - spent
      slowest = max(slowest, spent)
      if (spent > most_seconds) call give_up('takes too long')
    end do
    write (output_unit, '(2x,i0,a,f0.2,a,i0,a)') good, ' are records; slowest: ', slowest, ' s; memory so far: ', &
      most_memory()/1000, ' MB'
    if (most_memory() > most_kilobytes) call give_up('takes too much memory, or one before it does')
  end do
  call remove()
  flush (output_unit)
  call leave(0)

contains

  subroutine write_record()
    !! A record of the kind.
    character(:), allocatable :: text
    type(ieee_status_type) :: floating
    if (kind <= 2) then
      text = odd_table(random, sound=kind == 2)
    else
      call ieee_get_status(floating)
      call ieee_set_halting_mode(ieee_all, .false.)      ! the library turns numbers into types that are too small for them
      call write_odd_netcdf(random, file)
      call ieee_set_status(floating)
      return
    end if
    if (kind == 2) call damage_bytes(random, text)
    call write_bytes(text)
  end subroutine write_record

  subroutine write_bytes(text)
    character(*), intent(in) :: text
    integer :: unit
    open (newunit=unit, file=file, access='stream', form='unformatted', status='replace')
    write (unit) text
    close (unit)
  end subroutine write_bytes

  subroutine read_it()
    !! Read the record, and judge what comes of it.
    type(scene_type) :: scene
    type(result_layout) :: layout
    type(record_extent), allocatable :: extents(:)
    type(record_type) :: record
    type(error_type), allocatable :: error
    character(:), allocatable :: said
    call read_scene_text("&spectrum / &record file = '"//file//"'"//random_names(random)//' /', 'x.nml', scene, error)
    if (allocated(error)) call give_up('the scene is refused: '//error%message)
    layout = layout_of(scene)
    call plan_record(scene, layout, extents, record, error)
    if (allocated(error)) then
      if (error%status /= status_bad_input .and. error%status /= status_bad_file) call give_up(error%message)
      if (scan(error%message, new_line('a')) > 0) call give_up('more than one line: '//error%message)
      if (index(error%message, file) /= 1 .and. index(error%message, 'x.nml') /= 1) call give_up('no place: '//error%message)
    else
      good = good + 1
      said = record_summary(extents(1))
      if (.not. all(ieee_is_finite(record%values))) call give_up('numbers are not finite')
      if (.not. all(record%times(2:) > record%times(:size(record%times) - 1))) call give_up('times do not rise')
      if (size(record%times) /= size(record%values, 1) .or. size(record%sensors) /= size(record%values, 2) .or. &
          len(said) == 0) call give_up('sizes differ')
    end if
  end subroutine read_it

  real(dp) function processor_seconds() result(seconds)
    integer(c_long) :: usage(18)
    integer(c_int) :: ignored
    ignored = getrusage(0_c_int, usage)
    seconds = usage(1) + usage(3) + 1.0e-6_dp*(usage(2) + usage(4))
  end function processor_seconds

  integer(i8) function most_memory() result(kilobytes)
    integer(c_long) :: usage(18)
    integer(c_int) :: ignored
    ignored = getrusage(0_c_int, usage)
    kilobytes = usage(5)
  end function most_memory

  subroutine give_up(problem)
    character(*), intent(in) :: problem
    write (error_unit, '(6a,2(1x,i0),2a)') file, ', of ', trim(kinds(kind)), ' (', begin%seed_text(), ' fuzz_records 1', kind, &
      kind, '): ', problem
    flush (error_unit)
    call leave(1)
  end subroutine give_up

  subroutine remove()
    integer :: unit
    open (newunit=unit, file=file, status='old')
    close (unit, status='delete')
  end subroutine remove

end program fuzz_records
