program beamwave
  !! Bending waves in a beam that is struck by a mass.
  use bw_main, only: main
  use bw_process_group, only: process_group
  implicit none (type, external)
  type(process_group) :: group
  call main(group)
end program beamwave
