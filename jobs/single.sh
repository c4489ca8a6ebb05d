#!/bin/sh
# Scenes on one core:
#
#   sbatch jobs/single.sh SCENE.nml … [--output DIR]
#
# The job's state is the run's: COMPLETED, or FAILED with the exit status. A minute or two before the time limit
# Slurm asks the run to stop: what is finished is saved, the status is 5, and the same command goes on from there.
#SBATCH --job-name=beamwave
#SBATCH --ntasks=1
#SBATCH --time=01:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --output=%x-%j.log

# module load gcc openblas fftw minpack netcdf-fortran
set -eu
export OPENBLAS_NUM_THREADS=1
exec beamwave run "$@"
