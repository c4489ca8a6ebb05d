program beamwave
  !! Bending waves in a rotating beam struck at its tip.
  use bw_alone, only: alone
  use bw_main, only: main
  implicit none (type, external)
  type(alone) :: crew
  call main(crew)
end program beamwave
