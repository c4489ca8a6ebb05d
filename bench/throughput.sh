#!/usr/bin/env bash
# bench/throughput.sh [--small] [--redraw]   cases per second of sweeps beside a numpy loop and a multiprocessing pool
set -eu
. "$(dirname -- "$0")/common/run.sh"
if command -v mpifort > /dev/null && command -v mpirun > /dev/null; then bench_target=beamwave-mpi; fi
run_bench throughput "$@"
