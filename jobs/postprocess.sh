#!/bin/sh
# Spectral post-processing of results, once the job that makes them is done:
#
#   job=$(sbatch --parsable jobs/single.sh SCENE.nml)
#   sbatch --dependency="afterok:$job" jobs/postprocess.sh output/SCENE.nc …
#
# Beside each file: its pictures (spectra, waves as measured and as computed, …), and <stem>_peaks.csv, a line for
# each spectral peak. Needs a python3 that has beamwave_postproc: pip install ./postproc, in a venv.
#SBATCH --job-name=postprocess
#SBATCH --ntasks=1
#SBATCH --time=00:30:00
#SBATCH --output=%x-%j.log

# module load python; . ~/beamwave/.venv/bin/activate
set -eu
export OPENBLAS_NUM_THREADS=1
beamwave-plot "$@"
exec python3 -m beamwave_postproc.peaks "$@"
