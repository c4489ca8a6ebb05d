#!/usr/bin/env bash
# bench/records.sh [--small] [--redraw] [--output DIR]   lines in noise: error, intervals and time, beside other tools
set -eu
. "$(dirname -- "$0")/common/run.sh"
# the other tools bring much with them: a Python of their own. harminv is a command of the system (Debian: harminv)
bench_venv=$root/build/bench/rivals bench_packages=$bench/records/requirements.txt
run_bench records "$@"
