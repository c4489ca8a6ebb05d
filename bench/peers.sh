#!/usr/bin/env bash
# bench/peers.sh [--small] [--redraw] [--output DIR]   error against seconds, beamwave beside what else one could pick
set -eu
. "$(dirname -- "$0")/common/run.sh"
run_bench peers "$@"
