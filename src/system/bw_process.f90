module bw_process
  !! This process: how it ends, the signals that ask it to stop, and what the system has to grant it.
  !!
  !! A run-time error of the Fortran library ends a program with 1 or 2, which would look like bad input. So a handler
  !! that runs at exit turns every ending but `leave` into `status_fault`, or into `status_bad_file` where memory was refused.
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
  use bw_error, only: error_type, fail, status_bad_file, status_fault, status_stopped
  use bw_kinds, only: dp, i8
  use bw_system_calls, only: bw_free_disk, bw_free_memory, bw_leave, bw_open_standard_streams, bw_pause, &
    bw_set_ending, bw_set_environment, bw_prepare_openblas, bw_stop_after, bw_stop_asked, bw_watch
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: free_disk, free_memory, open_standard_streams, watch_over_process, prepare_libraries
  public :: leave, pause, stop_after, stop_asked

  type :: ending_type
    !! What is said of an ending that is none of ours, and its status.
    character(kind=c_char, len=120) :: message
    integer :: status
  end type ending_type

  type(ending_type), parameter :: endings(0:4) = [ &
    ending_type('a fault in the program: please report it', status_fault), &
    ending_type('memory was refused', status_bad_file), &
    ending_type('the stack is exhausted; accepted: a larger one (ulimit -s)', status_bad_file), &
    ending_type('stopped within a step that could not be left in order; finished cases are saved', status_stopped), &
    ending_type('a file that was being written was cut short, or its disk is full or failed', status_bad_file)]
    !! by the numbers of bw_system.c
  character(kind=c_char, len=200), target :: said(0:size(endings) - 1)      !! stays there for handlers of signals
  integer(i8), parameter :: openblas_bytes = 140000000    !! what it claims at its first call, and hardly uses

contains

  subroutine open_standard_streams()
    !! Open streams that are closed to nowhere; else the first file that is opened would take their place. Call this first.
    call bw_open_standard_streams()
  end subroutine open_standard_streams

  subroutine watch_over_process()
    !! Watch for signals, and for endings that are none of ours. Call this once, before any work is done.
    integer :: i
    do i = 0, size(endings) - 1
      said(i) = 'beamwave: '//trim(endings(i)%message)//new_line('a')//c_null_char
      call bw_set_ending(int(i, c_int), said(i), int(endings(i)%status, c_int))
    end do
    call bw_watch()
  end subroutine watch_over_process

  subroutine prepare_libraries(scene, error)
    !! See to it that libraries use one thread and no locks of their own: those of HDF5 are not there on every file system.
    !! **Errors**: OpenBLAS's memory is refused.
    character(*), intent(in) :: scene                !! file of the first scene that is to be run, for messages
    type(error_type), allocatable, intent(out) :: error
    call bw_set_environment('HDF5_USE_FILE_LOCKING'//c_null_char, 'FALSE'//c_null_char)
    if (bw_prepare_openblas(openblas_bytes) /= 0) then
      call fail(error, status_bad_file, scene//': memory was refused: the linear algebra (OpenBLAS) claims '// &
                text_of(openblas_bytes/1000000)//' MB')
    end if
  end subroutine prepare_libraries

  integer(i8) function free_disk(path) result(bytes)
    !! What may still be written where a path is; below 0: not known.
    character(*), intent(in) :: path
    bytes = bw_free_disk(path//c_null_char)
  end function free_disk

  integer(i8) function free_memory() result(bytes)
    !! Memory that the machine can still grant without swapping, as far as it tells; below 0: not known.
    bytes = bw_free_memory()
  end function free_memory

  subroutine stop_after(seconds)
    !! Ask to stop after so many seconds, as a signal does.
    real(dp), intent(in) :: seconds                  !! ≥ 0
    call bw_stop_after(seconds)
  end subroutine stop_after

  logical function stop_asked()
    !! A signal or the time has asked to stop. Who looks has to stop in order. Where nobody looks during a second of work the process
    !! ends at once, as it does ten seconds of work after somebody has looked, and at a second signal.
    stop_asked = bw_stop_asked() /= 0
  end function stop_asked

  subroutine leave(status)
    !! End the process with this status, at once: all is written and closed, and what libraries do at exit can crash
    !! (HDF5 over a file that was refused) or hang (OpenBLAS over threads whose memory was refused).
    integer, intent(in) :: status
    call bw_leave(int(status, c_int))
  end subroutine leave

  subroutine pause(microseconds)
    !! Leave the processor to others for a moment.
    integer, intent(in) :: microseconds              !! below a million
    call bw_pause(int(microseconds, c_int))
  end subroutine pause

end module bw_process
