module bw_existing_result
  !! Check of a file already in the place of a result. A file that cannot be read is not taken for one of another scene.
  use bw_case_result, only: case_done
  use bw_classic_reader, only: classic_reader
  use bw_descriptors, only: close_file, open_file, read_bytes, to_read
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_file_lock, only: is_locked_to_write
  use bw_files, only: cannot_be_read, look_at, path_state
  use bw_kinds, only: i1, i8
  use bw_netcdf_path, only: has_backslash
  use bw_result_header, only: source_text
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_system_calls, only: is_directory, is_file
  implicit none (type, external)
  private
  public :: check_result_path, look_at_existing

  type, public :: existing_result
    !! A finished result of the same scene and version, if there is one.
    logical :: is_there = .false.                  !! nothing is left to do
    integer(i8) :: not_trusted = 0                 !! number of its cases with numbers that cannot be trusted
    character(:), allocatable :: report            !! its attributes of these names
    character(:), allocatable :: notes
  end type existing_result

  character(*), parameter :: hdf5 = char(137)//'HDF'    !! first bytes of results of format 1

contains

  pure subroutine check_result_path(path, error)
    !! Check that a result can have this path.
    !! **Errors**: NetCDF would look for it elsewhere.
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(out) :: error
    if (has_backslash(path)) call fail(error, status_bad_input, path//': the NetCDF library reads a backslash as a slash, and '// &
                                       'would not find it; accepted: a path without backslashes')
  end subroutine check_result_path

  subroutine look_at_existing(path, scene, overwrite, existing, error, study, checksums)
    !! Keep a finished result of the same scene and version; refuse any other unless it may be replaced.
    !! **Errors**: also if it cannot be read, or is locked.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    logical, intent(in) :: overwrite
    type(existing_result), intent(out) :: existing
    type(error_type), allocatable, intent(out) :: error
    character(*), intent(in), optional :: study    !! the study that makes the result; absent: a run
    character(*), intent(in), optional :: checksums   !! of the files of its record or loads; absent: none
    type(path_state) :: state
    integer :: problem, descriptor, ignored
    call check_result_path(path, error)
    if (allocated(error)) return
    problem = look_at(path, state)
    if (problem /= 0) call cannot_be_read(error, path, problem)
    if (state%kind == is_directory) call fail(error, status_bad_file, path//': is a directory')
    if (state%kind > is_directory) call fail(error, status_bad_file, path//': is neither a file nor a directory')
    if (state%kind /= is_file .or. allocated(error)) return
    problem = open_file(path, to_read, descriptor)
    if (problem /= 0) then
      call cannot_be_read(error, path, problem)
    else if (is_locked_to_write(descriptor)) then
      call fail(error, status_bad_file, path//': is locked: another program is changing it')
    else
      call judge(path, descriptor, state%bytes, scene, overwrite, existing, error, study, checksums)
    end if
    ignored = close_file(descriptor)
  end subroutine look_at_existing

  subroutine judge(path, descriptor, length, scene, overwrite, existing, error, study, checksums)
    !! Identify a file.
    !! **Errors**: as above.
    character(*), intent(in) :: path
    integer, intent(in) :: descriptor
    integer(i8), intent(in) :: length              !! of the file
    type(scene_type), intent(in) :: scene
    logical, intent(in) :: overwrite
    type(existing_result), intent(inout) :: existing
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: study, checksums
    type(classic_reader) :: reader
    character(:), allocatable :: start, of_design
    integer(i1), allocatable :: statuses(:)        ! big-endian integers of four bytes
    integer(i8) :: have
    integer :: problem
    of_design = ''
    if (allocated(scene%design)) of_design = scene%design%checksum
    call reader%read_file(descriptor, length, 'case_status', start, problem)
    if (problem /= 0) call cannot_be_read(error, path, problem)
    if (allocated(error)) return
    if (reader%is_sound .and. reader%length <= length) then
      existing%is_there = is_text('scene', resolved_text(scene)) .and. is_text('source', source_text()) .and. &
        is_text('study', study) .and. is_text('design_checksum', of_design) .and. &
        (is_text('record_checksum', checksums) .or. is_text('load_checksum', checksums))
      existing%report = reader%text_of('report')
      existing%notes = reader%text_of('notes')
      allocate (statuses(merge(reader%bytes, 0_i8, existing%is_there)))
      problem = read_bytes(descriptor, reader%place, statuses, have)
      if (problem /= 0) call cannot_be_read(error, path, problem)
      existing%not_trusted = count(statuses(4:have:4) /= case_done, kind=i8)      ! studies have no statuses
      if (.not. existing%is_there .and. .not. overwrite) call fail(error, status_bad_file, path// &
        ': is there already, of another scene or version; --overwrite replaces it')
    else if (index(start, hdf5) == 1 .and. .not. overwrite) then
      call fail(error, status_bad_file, path//': is there already, of another version; --overwrite replaces it')
    else if (.not. overwrite) then
      call fail(error, status_bad_file, path//': is damaged, cut short or no NetCDF file; --overwrite replaces it')
    end if
  contains
    logical function is_text(name, text)
      character(*), intent(in) :: name
      character(*), intent(in), optional :: text   !! absent: empty
      is_text = reader%text_of(name) == ''
      if (present(text)) is_text = reader%text_of(name) == text
    end function is_text
  end subroutine judge

end module bw_existing_result
