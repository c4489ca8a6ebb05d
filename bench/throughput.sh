#!/usr/bin/env bash
# bench/throughput.sh [--small] [--redraw]   cases per second of sweeps beside a numpy loop and a multiprocessing pool
set -eu
. "$(dirname -- "$0")/../src/cmake/setup.sh"

lock
set_up default
set_up_python beamwave_postproc || die 'missing: Python 3 with numpy'
unlock
export OMP_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$root/bench
exec "$python" -m throughput "$@"
