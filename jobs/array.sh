#!/bin/bash
# A directory of scenes, shared out among the tasks of a job array:
#
#   sbatch --array=1-20 jobs/array.sh DIRECTORY [--output DIR]
#
# With as many tasks as scenes each has one. A task with a bad scene runs its good ones and ends as FAILED (2), with
# the reason in its log. The same command once more does what is not finished; results that are there stay.
#SBATCH --job-name=beamwave
#SBATCH --ntasks=1
#SBATCH --time=01:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --output=%x-%A_%a.log

# module load gcc openblas fftw minpack netcdf-fortran
set -eu
export OPENBLAS_NUM_THREADS=1

tasks=${SLURM_ARRAY_TASK_COUNT:-}
[ -n "$tasks" ] || { echo 'array.sh: this is no task of an array; submit it by sbatch --array=1-20' >&2; exit 2; }
first=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN))
if [ $((SLURM_ARRAY_TASK_MAX - SLURM_ARRAY_TASK_MIN + 1)) -ne "$tasks" ]; then
  echo 'array.sh: scenes are shared out among the tasks of an array without gaps, as --array=1-20' >&2
  exit 2
fi
scenes=("${1:?array.sh: a directory of scenes is missing}"/*.nml)
shift
[ -e "${scenes[0]}" ] || { echo "array.sh: no such scenes: ${scenes[0]}" >&2; exit 2; }

mine=()
for ((i = first; i < ${#scenes[@]}; i += tasks)); do
  mine+=("${scenes[i]}")
done
[ ${#mine[@]} -gt 0 ] || exit 0
exec beamwave run "${mine[@]}" "$@"
