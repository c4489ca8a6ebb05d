#!/usr/bin/env bash
# bench/growth.sh [--small] [--redraw] [--output DIR]   time and memory of a run against modes, samples and points
set -eu
. "$(dirname -- "$0")/common/run.sh"
run_bench growth "$@"
