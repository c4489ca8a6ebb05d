program beamwave
  !! Bending waves in a rotating beam struck at its tip.
  use bw_lone_process, only: lone_process
  use bw_main, only: main
  implicit none (type, external)
  type(lone_process) :: group
  call main(group)
end program beamwave
