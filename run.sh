#!/usr/bin/env bash
# ./run.sh          builds, runs every scene in input/paper/ and draws the figures, into output/paper/
# ./run.sh PATH …   builds and runs these scenes or directories: what `beamwave run PATH …` does, with its status
# Where MPI is installed, beamwave-mpi is built as well. It is not installed here: a single run needs none.
set -eu
. "$(dirname -- "$0")/src/cmake/setup.sh"

beamwave=$root/build/bin/beamwave

# the figures are what Python is for: without it the results are there all the same
draw_paper() {
  if ! set_up_python beamwave_postproc; then
    say 'no figures without Python 3 (with venv and pip); the results are in output/paper/'
    return
  fi
  "$python" -m beamwave_postproc.paper output/paper --overwrite
}

lock
set_up default --target programs
if [ $# -gt 0 ]; then
  unlock
  exec "$beamwave" run "$@"
fi
cd "$root"
"$beamwave" run input/paper --output output/paper --overwrite 9>&-
draw_paper
