module bw_processor
  !! What machine this is: seconds mean nothing without it.
  implicit none (type, external)
  private
  public :: processor_name

contains

  function processor_name() result(name)
    !! The processor's model as Linux tells it; 'unknown' where it does not.
    character(:), allocatable :: name
    character(200) :: line
    integer :: unit, stat
    name = 'unknown'
    open (newunit=unit, file='/proc/cpuinfo', status='old', action='read', iostat=stat)
    if (stat /= 0) return
    do
      read (unit, '(a)', iostat=stat) line
      if (stat /= 0) exit
      if (index(line, 'model name') /= 1) cycle
      name = trim(adjustl(line(index(line, ':') + 1:)))
      exit
    end do
    close (unit)
  end function processor_name

end module bw_processor
