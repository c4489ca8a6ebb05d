module bw_process
  !! This process: how it ends, signals that ask it to stop, and resources of the system.
  !!
  !! A run-time error of the Fortran library ends a program with status 1 or 2, which would look like bad input. So an
  !! exit handler turns every ending except `leave` into `status_fault`, or into `status_bad_file` if memory was
  !! refused. `leave` ends the process at once: all files are written and closed, and exit handlers of libraries can
  !! crash (HDF5 on a refused file) or hang (OpenBLAS without memory for its threads).
  use, intrinsic :: iso_c_binding, only: c_null_char
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: i8
  use bw_system_calls, only: bw_free_disk, bw_prepare_openblas, bw_set_environment, bw_stop_asked, &
    & free_memory => bw_free_memory, leave => bw_leave, open_standard_streams => bw_open_standard_streams, pause => bw_pause, &
    & stop_after => bw_stop_after, watch_over_process => bw_watch
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: free_disk, free_memory, open_standard_streams, watch_over_process, prepare_libraries
  public :: leave, pause, stop_after, stop_asked

  integer(i8), parameter :: openblas_bytes = 140000000    !! claimed at its first call, and hardly used

contains

  subroutine prepare_libraries(scene, error)
    !! Make libraries use one thread, and disable HDF5's file locks, which some file systems lack.
    !! **Errors**: OpenBLAS's memory is refused.
    character(*), intent(in) :: scene                !! file of the first scene to run, for messages
    type(error_type), allocatable, intent(out) :: error
    call bw_set_environment('HDF5_USE_FILE_LOCKING'//c_null_char, 'FALSE'//c_null_char)
    if (bw_prepare_openblas(openblas_bytes) /= 0) then
      call fail(error, status_bad_file, scene//': not enough memory: the linear algebra (OpenBLAS) claims '// &
                text_of(openblas_bytes/1000000)//' MB')
    end if
  end subroutine prepare_libraries

  integer(i8) function free_disk(path) result(bytes)
    !! Return the free disk space at a path, bytes; below 0: unknown.
    character(*), intent(in) :: path
    bytes = bw_free_disk(path//c_null_char)
  end function free_disk

  logical function stop_asked()
    !! Return whether a signal or the time limit has requested a stop. After true the caller has to stop. Without such a check
    !! during one second of work the process ends at once, as it does ten seconds of work after a check, or at a second signal.
    stop_asked = bw_stop_asked() /= 0
  end function stop_asked

end module bw_process
