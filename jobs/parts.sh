#!/bin/sh
# The cases of a sweep, shared out among the tasks of a job array, into one result, without MPI:
#
#   sbatch --array=1-20 jobs/parts.sh SCENE.nml [--output DIR]
#
# Tasks run in any order, at the same time or not. The last to end makes the result. The same command once more does what is
# not finished.
#SBATCH --job-name=beamwave
#SBATCH --ntasks=1
#SBATCH --time=01:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --output=%x-%A_%a.log

# module load gcc openblas fftw minpack netcdf-fortran
set -eu
export OPENBLAS_NUM_THREADS=1

tasks=${SLURM_ARRAY_TASK_COUNT:-}
[ -n "$tasks" ] || { echo 'parts.sh: this is no task of an array; submit it by sbatch --array=1-20, or use parallel.sh' >&2; exit 2; }
part=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN + 1))
if [ $((SLURM_ARRAY_TASK_MAX - SLURM_ARRAY_TASK_MIN + 1)) -ne "$tasks" ]; then
  echo 'parts.sh: cases are shared out among the tasks of an array without gaps, as --array=1-20' >&2
  exit 2
fi
exec beamwave run "$@" --part "$part/$tasks"
