program beamwave_mpi
  !! The twin of `beamwave` for mpirun: the same, but that it hands out the cases of sweeps among processes.
  use bw_main, only: main
  use bw_mpi_crew, only: mpi_crew
  implicit none (type, external)
  type(mpi_crew) :: crew
  call main(crew)
end program beamwave_mpi
