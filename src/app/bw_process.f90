module bw_process
  !! How the process ends: its exit status, the signals that ask it to stop, and faults.
  !!
  !! A run-time error of the Fortran library ends a program with 1 or 2, which would look like bad input. So a handler
  !! that runs at exit turns every ending but `leave` into `status_fault`.
  use, intrinsic :: iso_c_binding, only: c_associated, c_f_procpointer, c_funloc, c_funptr, c_int, c_intptr_t
  use bw_error, only: status_fault
  use bw_posix, only: loaded_procedure, standard_error, write_text
  implicit none (type, external)
  private
  public :: watch_over_process, use_one_thread, stop_signal, leave

  integer(c_int), parameter :: sigint = 2, sigusr1 = 10, sigterm = 15                    ! Linux, any processor
  integer(c_int), parameter :: sigill = 4, sigabrt = 6, sigbus = 7, sigfpe = 8, sigsegv = 11
  integer(c_int), parameter :: sigxfsz = 25       ! a file grew beyond `ulimit -f`
  integer(c_int), parameter :: fault_signals(*) = [sigill, sigabrt, sigbus, sigfpe, sigsegv]

  character(*), parameter :: fault_message = 'beamwave: a fault in the program: please report it'//new_line('a')

  integer(c_int), volatile :: received = 0       ! the last signal that asked to stop

  abstract interface
    subroutine set_threads(count) bind(c)
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: count
    end subroutine set_threads
  end interface

  interface
    type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
      import :: c_funptr, c_int
      implicit none (type, external)
      integer(c_int), value :: number
      type(c_funptr), value :: handler
    end function c_signal
    integer(c_int) function c_atexit(handler) bind(c, name='atexit')
      import :: c_funptr, c_int
      implicit none (type, external)
      type(c_funptr), value :: handler
    end function c_atexit
    subroutine c_exit_now(status) bind(c, name='_exit')
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: status
    end subroutine c_exit_now
  end interface

contains

  subroutine watch_over_process()
    !! Call once, first.
    type(c_funptr) :: ignored
    integer(c_int) :: status
    integer :: i
    status = c_atexit(c_funloc(on_exit))
    ignored = c_signal(sigint, c_funloc(on_stop))
    ignored = c_signal(sigterm, c_funloc(on_stop))
    ignored = c_signal(sigusr1, c_funloc(on_stop))
    ignored = c_signal(sigxfsz, transfer(1_c_intptr_t, ignored))    ! SIG_IGN: the write fails, as on a full disk
    do i = 1, size(fault_signals)
      ignored = c_signal(fault_signals(i), c_funloc(on_fault))
    end do
  end subroutine watch_over_process

  subroutine use_one_thread()
    !! A process uses one thread. Where LAPACK is OpenBLAS with threads of its own, tell it; elsewhere there is no such
    !! procedure and nothing to tell.
    type(c_funptr) :: address
    procedure(set_threads), pointer :: set_openblas_threads
    address = loaded_procedure('openblas_set_num_threads')
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, set_openblas_threads)
    call set_openblas_threads(1_c_int)
  end subroutine use_one_thread

  integer function stop_signal()
    !! The signal that asked to stop; 0 for none.
    stop_signal = int(received)
  end function stop_signal

  subroutine leave(status)
    !! End the process with this status, at once: all is written and closed, and what libraries do at exit can crash
    !! (HDF5 over a file that was refused) or hang (OpenBLAS over threads whose memory was refused).
    integer, intent(in) :: status
    call c_exit_now(int(status, c_int))
  end subroutine leave

  subroutine on_stop(number) bind(c)
    !! Remember the signal; a second one ends the process at once.
    integer(c_int), value :: number
    if (received /= 0) call c_exit_now(128_c_int + number)
    received = number
  end subroutine on_stop

  subroutine on_fault(number) bind(c)
    !! Nothing here may allocate: the heap may be what is broken.
    integer(c_int), value :: number
    logical :: ignored
    ignored = write_text(standard_error, fault_message)
    call c_exit_now(int(status_fault, c_int) + 0_c_int*number)
  end subroutine on_fault

  subroutine on_exit() bind(c)
    logical :: ignored
    ignored = write_text(standard_error, fault_message)
    call c_exit_now(int(status_fault, c_int))
  end subroutine on_exit

end module bw_process
