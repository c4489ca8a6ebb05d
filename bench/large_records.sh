#!/usr/bin/env bash
# bench/large_records.sh [--small] [--redraw] [--output DIR]   time and memory of a record's lines against samples and sensors
set -eu
. "$(dirname -- "$0")/common/run.sh"
run_bench large_records "$@"
