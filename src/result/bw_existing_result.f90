module bw_existing_result
  !! What a command finds where its result will lie. Only what has been read is judged: a file that cannot be read is not
  !! thereby one of another scene.
  use bw_case_result, only: case_done
  use bw_child_process, only: child_process
  use bw_descriptors, only: close_file, open_file, read_bytes, to_read
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_file_lock, only: is_locked_to_write
  use bw_files, only: cannot_be_read, look_at, path_state
  use bw_kinds, only: i1, i8
  use bw_netcdf_path, only: has_backslash
  use bw_netcdf_reading, only: of_the_file, open_netcdf, read_text
  use bw_result_header, only: source_text
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_system_calls, only: is_directory, is_file
  use bw_text, only: append, string, text_of
  use netcdf, only: nf90_enomem, nf90_enotvar, nf90_get_var, nf90_inq_varid, nf90_inquire_dimension, nf90_inquire_variable, &
    nf90_noerr, nf90_strerror
  implicit none (type, external)
  private
  public :: look_at_existing

  type, public :: existing_result
    !! A finished result of the same scene and version, if there is one.
    logical :: is_there = .false.                  !! there is nothing to do
    integer(i8) :: not_trusted = 0                 !! how many of its cases hold numbers that cannot be trusted
    character(:), allocatable :: report            !! its attributes of these names
    character(:), allocatable :: notes
  end type existing_result

  character(*), parameter :: same = 'same', other = 'other', damaged = 'damaged'     !! what it is found to be
  integer, parameter :: at_once = 65536            !! numbers, or bytes, that are read at a time
  integer, parameter :: most_seconds = 5           !! of processor time to look at a result

contains

  subroutine look_at_existing(path, scene, overwrite, existing, error, study, record)
    !! A finished result of the same scene and version is left alone; another is an error unless it may be replaced.
    !! **Errors**: also where it cannot be read, or is locked.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    logical, intent(in) :: overwrite
    type(existing_result), intent(out) :: existing
    type(error_type), allocatable, intent(out) :: error
    character(*), intent(in), optional :: study    !! the study whose result it is; absent: a run's
    character(*), intent(in), optional :: record   !! checksums of the scene's record; absent: it has none
    type(path_state) :: state
    character(:), allocatable :: found
    integer :: problem
    if (has_backslash(path)) call fail(error, status_bad_input, path//': NetCDF takes a backslash for a slash, and would '// &
                                       'write elsewhere; accepted: a path without')
    if (allocated(error)) return
    problem = look_at(path, state)
    if (problem /= 0) call cannot_be_read(error, path, problem)
    if (state%kind == is_directory) call fail(error, status_bad_file, path//': is a directory')
    if (state%kind > is_directory) call fail(error, status_bad_file, path//': is neither a file nor a directory')
    if (state%kind /= is_file .or. allocated(error)) return
    call find_out(path, scene, found, existing, error, study, record)
    if (allocated(error)) return
    existing%is_there = found == same
    if (existing%is_there .or. overwrite) return
    if (found == other) call fail(error, status_bad_file, path//': is there already, of another scene or version; '// &
                                  '--overwrite replaces it')
    if (found == damaged) call fail(error, status_bad_file, path//': is damaged, cut short or no NetCDF-4 file; '// &
                                    '--overwrite replaces it')
  end subroutine look_at_existing

  subroutine find_out(path, scene, found, existing, error, study, record)
    !! What a file is. NetCDF has one word for all that it cannot read: what the system refuses is found by reading it.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    character(:), allocatable, intent(out) :: found
    type(existing_result), intent(inout) :: existing
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: study, record
    type(child_process) :: child
    type(string), allocatable :: texts(:)
    logical :: whole
    integer :: descriptor, problem, ignored
    problem = open_file(path, to_read, descriptor)
    if (problem /= 0) call cannot_be_read(error, path, problem)
    if (allocated(error)) return
    if (is_locked_to_write(descriptor)) then
      call fail(error, status_bad_file, path//': is locked: another program is changing it')
    else
      call child%begin(most_seconds)
      if (child%is_here()) then
        call compare(path, scene, texts, error, study, record)
        call child%tell(texts, error)
      end if
      call child%hear(texts, whole, error)
      if (allocated(error)) error%message = path//': '//error%message
    end if
    if (.not. allocated(error)) then
      found = texts(1)%text
      read (texts(2)%text, *) existing%not_trusted
      existing%report = texts(3)%text
      existing%notes = texts(4)%text
      if (found == damaged) call read_through(path, descriptor, error)
    end if
    ignored = close_file(descriptor)
  end subroutine find_out

  subroutine read_through(path, descriptor, error)
    !! **Errors**: the system refuses to read some of a file.
    character(*), intent(in) :: path
    integer, intent(in) :: descriptor
    type(error_type), allocatable, intent(inout) :: error
    integer(i1) :: bytes(at_once)
    integer(i8) :: place, have
    integer :: problem
    place = 0
    do
      problem = read_bytes(descriptor, place, bytes, have)
      if (problem /= 0) call cannot_be_read(error, path, problem)
      if (problem /= 0 .or. have == 0) return
      place = place + have
    end do
  end subroutine read_through

  subroutine compare(path, scene, texts, error, study, record)
    !! Whether a file is the result of the same resolved scene by the same version, how many of its cases hold numbers that
    !! cannot be trusted, its report and its notes. The file is not closed: the process ends.
    !! **Errors**: memory is refused.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(string), allocatable, intent(out) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: study, record
    character(:), allocatable :: found, wanted, report, notes
    integer(i8) :: cases
    integer :: file, status
    wanted = ''
    if (present(study)) wanted = study
    found = same
    cases = 0
    call open_netcdf(path, file, status)
    call compare_text(file, 'scene', resolved_text(scene), found, status)
    call compare_text(file, 'source', source_text(), found, status)
    call compare_text(file, 'study', wanted, found, status)
    wanted = ''
    if (present(record)) wanted = record
    call compare_text(file, 'record_checksum', wanted, found, status)
    if (found == same) call count_not_trusted(file, cases, status)
    call read_text(file, of_the_file, 'report', report, status)
    call read_text(file, of_the_file, 'notes', notes, status)
    if (status == nf90_enomem) call fail(error, status_bad_file, 'cannot be read: '//trim(nf90_strerror(status)))
    if (status /= nf90_noerr) found = damaged
    call append(texts, found)
    call append(texts, text_of(cases))
    call append(texts, report)
    call append(texts, notes)
  end subroutine compare

  subroutine compare_text(file, name, wanted, found, status)
    !! Whether a global attribute is another.
    integer, intent(in) :: file
    character(*), intent(in) :: name, wanted
    character(:), allocatable, intent(inout) :: found
    integer, intent(inout) :: status               !! of NetCDF; nothing is done after a failure
    character(:), allocatable :: text
    call read_text(file, of_the_file, name, text, status)
    if (status == nf90_noerr .and. text /= wanted) found = other
  end subroutine compare_text

  subroutine count_not_trusted(file, cases, status)
    !! How many cases have a `case_status` other than done; studies have none.
    integer, intent(in) :: file
    integer(i8), intent(inout) :: cases
    integer, intent(inout) :: status               !! of NetCDF; nothing is done after a failure
    integer :: dimension(1), first, length, rank, variable
    integer, allocatable :: ended(:)
    if (status == nf90_noerr) status = nf90_inq_varid(file, 'case_status', variable)
    if (status == nf90_noerr) status = nf90_inquire_variable(file, variable, ndims=rank)
    length = 1
    if (status == nf90_noerr .and. rank == 1) status = nf90_inquire_variable(file, variable, dimids=dimension)
    if (status == nf90_noerr .and. rank == 1) status = nf90_inquire_dimension(file, dimension(1), len=length)
    do first = 1, length, at_once
      if (status /= nf90_noerr) exit
      allocate (ended(min(at_once, length - first + 1)))
      if (rank == 1) then
        status = nf90_get_var(file, variable, ended, start=[first])
      else
        status = nf90_get_var(file, variable, ended(1))
      end if
      if (status == nf90_noerr) cases = cases + count(ended /= case_done)
      deallocate (ended)
    end do
    if (status == nf90_enotvar) status = nf90_noerr
  end subroutine count_not_trusted

end module bw_existing_result
