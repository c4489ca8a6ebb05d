#!/usr/bin/env bash
# bench/sum.sh [--small] [--redraw] [--repeats R]   modes and their sum beside numpy + FINUFFT, in one process
set -eu
. "$(dirname -- "$0")/common/run.sh"
bench_target=bench_sum
run_bench sum "$@"
