program beamwave_mpi
  !! `beamwave` for mpirun: the same program, except that processes share the cases of sweeps.
  use bw_main, only: main
  use bw_mpi_processes, only: mpi_processes
  implicit none (type, external)
  type(mpi_processes) :: group
  call main(group)
end program beamwave_mpi
