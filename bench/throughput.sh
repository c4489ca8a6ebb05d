#!/usr/bin/env bash
# bench/throughput.sh [--small] [--redraw]   cases per second of sweeps beside a numpy loop and a multiprocessing pool
set -eu
. "$(dirname -- "$0")/common/run.sh"
run_bench throughput "$@"
