#!/bin/bash
# A run that is longer than the time limit. It stops in order before the limit, and the job goes back into the queue
# under its own number, until all is done. Give it the whole command, which --max-seconds is added to:
#
#   sbatch --time=08:00:00 jobs/continue.sh beamwave run SCENE.nml [--output DIR]
#   sbatch --time=08:00:00 --ntasks=16 jobs/continue.sh mpirun beamwave-mpi run SCENE.nml
#
# Since the number stays, what depends on the job (--dependency=afterok:NUMBER) waits for its last part. A job that
# was cancelled stays so. The site may hold a job for a few minutes before it starts again.
#SBATCH --job-name=beamwave
#SBATCH --ntasks=1
#SBATCH --time=01:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=%x-%j.log

# module load gcc openmpi openblas fftw minpack netcdf-fortran
set -eu
export OPENBLAS_NUM_THREADS=1
margin=${BEAMWAVE_MARGIN:-120}    # s between the order to stop and the time limit
restarts=${BEAMWAVE_RESTARTS:-50} # then it is no longer a matter of time: a case can be longer than the limit

say() { echo "continue.sh: $*" >&2; }
of_this_job() { squeue --noheader --jobs="$SLURM_JOB_ID" --format="$1"; }

limit=$(date --date="$(of_this_job %e)" +%s)
seconds=$((limit - $(date +%s) - margin))
[ "$seconds" -gt 0 ] || { say "the time limit has to be longer than the margin of $margin s"; exit 2; }

status=0
"$@" --max-seconds "$seconds" || status=$?
[ "$status" -eq 5 ] || exit "$status"

[ "$(of_this_job %T)" = RUNNING ] || exit 5
[ "${SLURM_RESTART_COUNT:-0}" -lt "$restarts" ] || { say "not done after $restarts restarts"; exit 5; }
scontrol requeue "$SLURM_JOB_ID" || say 'the job cannot be queued again here: submit it once more'
exit 5
