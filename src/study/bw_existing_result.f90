module bw_existing_result
  !! What a command finds where its result will lie.
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_posix, only: file_exists, is_directory
  use bw_netcdf, only: has_backslash
  use bw_result_header, only: holds_scene
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: look_at_existing

contains

  subroutine look_at_existing(path, scene, overwrite, was_there, error, study)
    !! A finished result of the same scene and version is left alone; another is an error unless it may be replaced.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    logical, intent(in) :: overwrite
    logical, intent(out) :: was_there             !! there is nothing to do
    type(error_type), allocatable, intent(out) :: error
    character(*), intent(in), optional :: study   !! the study whose result it is; absent: a run's
    was_there = .false.
    if (has_backslash(path)) call fail(error, status_bad_input, path//': NetCDF takes a backslash for a slash, and would '// &
                                       'write elsewhere; accepted: a path without')
    if (allocated(error)) return
    if (is_directory(path)) call fail(error, status_bad_file, path//': is a directory')
    if (allocated(error)) return
    if (.not. file_exists(path)) return
    was_there = holds_scene(path, scene, study)
    if (was_there .or. overwrite) return
    call fail(error, status_bad_file, path//': is there already, of another scene or version; --overwrite replaces it')
  end subroutine look_at_existing

end module bw_existing_result
