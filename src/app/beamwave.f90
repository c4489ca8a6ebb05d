program beamwave
  !! Bending waves in a rotating beam struck at its tip.
  use bw_main, only: main
  use bw_process_group, only: process_group
  implicit none (type, external)
  type(process_group) :: group
  call main(group)
end program beamwave
