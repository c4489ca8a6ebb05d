#!/usr/bin/env bash
# bench/price.sh [--small] [--redraw] [--output DIR]   what accuracy costs: error and seconds of each tolerance
set -eu
. "$(dirname -- "$0")/common/run.sh"
run_bench price "$@"
