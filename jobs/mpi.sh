#!/bin/sh
# The cases of a sweep on many cores, into one result:
#
#   sbatch --ntasks=16 jobs/mpi.sh SCENE.nml [--output DIR]
#
# mpirun takes cores and nodes from the job. The result has the same bits for any number of ranks on processors of one kind.
#SBATCH --job-name=beamwave
#SBATCH --ntasks=4
#SBATCH --time=01:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --output=%x-%j.log

# module load gcc openmpi openblas fftw minpack netcdf-fortran
set -eu
export OPENBLAS_NUM_THREADS=1
exec mpirun beamwave-mpi run "$@"
