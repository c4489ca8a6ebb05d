#!/bin/bash
# The cases of a sweep, shared out by GNU parallel on the cores of one machine, into one result, without MPI:
#
#   jobs/parallel.sh SCENE.nml [--output DIR]                            # on all cores of this machine
#   sbatch --cpus-per-task=16 jobs/parallel.sh SCENE.nml [--output DIR]  # on those of a job
#
# The status is the highest of any part. After an order to stop (Ctrl-C, SIGTERM, SIGUSR1) all parts save what is finished and it
# is 5; the same command goes on from there, with any number of cores.
#SBATCH --job-name=beamwave
#SBATCH --ntasks=1
#SBATCH --time=01:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --output=%x-%j.log

# module load gcc openblas fftw minpack netcdf-fortran parallel
set -eu
export OPENBLAS_NUM_THREADS=1
cores=${SLURM_CPUS_PER_TASK:-$(nproc)}
command -v parallel > /dev/null || { echo 'parallel.sh: GNU parallel is missing' >&2; exit 3; }

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# on a second SIGTERM parallel sends it on to the parts, and waits until they have saved
seq "$cores" | parallel --will-cite --jobs "$cores" --line-buffer --joblog "$log" --termseq TERM,600000 \
  beamwave run "${@@Q}" --part "{}/$cores" &
crew=$!
stop() { { kill -TERM "$crew" && sleep 0.2 && kill -TERM "$crew"; } 2> /dev/null || true; }
trap stop INT TERM USR1
status=0
wait "$crew" || status=$?
while kill -0 "$crew" 2> /dev/null; do wait "$crew" || status=$?; done

# the 7th column is the status of a part
highest=$(awk 'NR > 1 && $7 > most { most = $7 } END { print most + 0 }' "$log")
[ "$status" -eq 0 ] || [ "$highest" -gt 0 ] || highest=5
exit "$highest"
