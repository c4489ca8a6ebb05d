module bw_process
  !! This process: how it ends, the signals that ask it to stop, and what the system has to grant it.
  !!
  !! A run-time error of the Fortran library ends a program with 1 or 2, which would look like bad input. So a handler
  !! that runs at exit turns every ending but `leave` into `status_fault`, or into `status_bad_file` where memory was refused.
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
  use bw_error, only: error_type, fail, status_bad_file, status_fault
  use bw_kinds, only: i8
  use bw_system_calls, only: bw_free_disk, bw_free_memory, bw_leave, bw_open_standard_streams, bw_pause, &
    bw_set_environment, bw_settle_openblas, bw_stack_limit, bw_stop_signal, bw_watch
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: free_disk, free_memory, open_standard_streams, watch_over_process, settle_libraries, stop_signal, leave, pause

  character(kind=c_char, len=*), parameter :: &
    fault_message = 'beamwave: a fault in the program: please report it'//new_line('a')//c_null_char, &
    stack_message = 'beamwave: the stack has too little room; accepted: 1024 kB or more (ulimit -s)'//new_line('a')// &
                    c_null_char, &
    memory_message = 'beamwave: memory was refused'//new_line('a')//c_null_char
  integer(i8), parameter :: least_stack = 2**20      !! bytes; a run takes a fifth of it
  integer(i8), parameter :: openblas_bytes = 140000000    !! what it claims at its first call, and hardly uses

contains

  subroutine open_standard_streams()
    !! Open streams that are closed to nowhere; else the first file that is opened would take their place. Call this first.
    call bw_open_standard_streams()
  end subroutine open_standard_streams

  subroutine watch_over_process()
    !! Watch for signals, and for endings that are none of ours: a fault on a small stack comes of that. Call this once, before
    !! any work is done.
    if (stack_is_small()) then
      call bw_watch(stack_message, int(status_bad_file, c_int), memory_message, int(status_bad_file, c_int))
    else
      call bw_watch(fault_message, int(status_fault, c_int), memory_message, int(status_bad_file, c_int))
    end if
  end subroutine watch_over_process

  subroutine settle_libraries(scene, error)
    !! See to it that libraries use one thread and no locks of their own: those of HDF5 are not there on every file system.
    !! **Errors**: the stack is too small, or OpenBLAS's memory is refused.
    character(*), intent(in) :: scene                !! file of the first scene that is to be run, for messages
    type(error_type), allocatable, intent(out) :: error
    call bw_set_environment('HDF5_USE_FILE_LOCKING'//c_null_char, 'FALSE'//c_null_char)
    if (stack_is_small()) then
      call fail(error, status_bad_file, scene//': the stack may have '//text_of(bw_stack_limit()/1024)//' kB, which is too '// &
                'small; accepted: '//text_of(least_stack/1024)//' kB or more (ulimit -s)')
    else if (bw_settle_openblas(openblas_bytes) /= 0) then
      call fail(error, status_bad_file, scene//': memory was refused: the linear algebra (OpenBLAS) claims '// &
                text_of(openblas_bytes/1000000)//' MB')
    end if
  end subroutine settle_libraries

  integer(i8) function free_disk(path) result(bytes)
    !! What may still be written where a path is; below 0: not known.
    character(*), intent(in) :: path
    bytes = bw_free_disk(path//c_null_char)
  end function free_disk

  integer(i8) function free_memory() result(bytes)
    !! Memory that the machine can still grant without swapping, as far as it tells; below 0: not known.
    bytes = bw_free_memory()
  end function free_memory

  logical function stack_is_small()
    !! Whether this process may have less stack than a run needs.
    integer(i8) :: stack
    stack = bw_stack_limit()
    stack_is_small = stack >= 0 .and. stack < least_stack        ! below 0: no limit
  end function stack_is_small

  integer function stop_signal()
    !! The signal that asked to stop; 0 for none. A second one ends the process at once.
    stop_signal = int(bw_stop_signal())
  end function stop_signal

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
