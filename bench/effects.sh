#!/usr/bin/env bash
# bench/effects.sh [--small] [--redraw] [--output DIR]   instructions and seconds of the paper's scene with each effect
set -eu
. "$(dirname -- "$0")/common/run.sh"
# valgrind does not know every instruction of the newest processors: it counts those of a build for any of them
cmake --preset default -S "$root" -B "$root/build/bench/portable" -DBEAMWAVE_NATIVE=OFF -DBEAMWAVE_TESTS=OFF > /dev/null
cmake --build "$root/build/bench/portable" --target beamwave > /dev/null
export BEAMWAVE_PORTABLE=$root/build/bench/portable/bin/beamwave
run_bench effects "$@"
