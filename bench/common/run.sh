#!/usr/bin/env bash
# bench/NAME.sh [--small] [--redraw] [--output DIR]   measures, and writes what bench/README.md says; each NAME.sh is this file.
# It builds the program, and makes a Python of the benches' own with the packages that bench/requirements.txt names; a second
# call installs nothing. Nothing is installed into the system's Python.
set -eu
. "$(dirname -- "$0")/../src/cmake/setup.sh"  # called as bench/NAME.sh

name=$(basename -- "$0" .sh)
bench=$root/bench
bench_venv=$root/build/bench/venv
bench_packages=$bench/requirements.txt
target=
export OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 MPLBACKEND=Agg PYTHONDONTWRITEBYTECODE=1
export PYTHONPATH=$bench:$root/postproc

# set_up_bench_python: packages that cannot be had are left out one by one, and the bench says which it misses
set_up_bench_python() {
  local stamp=$bench_venv/requirements.sum sum package
  sum=$(cksum < "$bench_packages")
  [ "$(cat "$stamp" 2> /dev/null)" = "$sum" ] && return
  say "installing the Python packages of ${bench_packages#"$root/"} into ${bench_venv#"$root/"}"
  logged bench-venv python3 -m venv --clear "$bench_venv" ||
    { apt_install python3 python3-venv && logged bench-venv python3 -m venv --clear "$bench_venv"; } ||
    die 'missing: Python 3 with venv'
  while read -r package; do
    logged bench-pip env PIP_USER=0 "$bench_venv/bin/python" -m pip install "$package" || {
      show_log bench-pip
      say "without $package"
    }
  done < "$bench_packages"
  echo "$sum" > "$stamp"
}

case $name in
effects)  # valgrind does not know every instruction of the newest processors: it counts those of a build for any of them
  portable=$root/build/bench/portable
  cmake --preset default -S "$root" -B "$portable" -DBEAMWAVE_NATIVE=OFF -DBEAMWAVE_TESTS=OFF > /dev/null
  cmake --build "$portable" --target beamwave > /dev/null
  export BEAMWAVE_PORTABLE=$portable/bin/beamwave
  ;;
records)  # the other tools bring much with them: a Python of their own. harminv is a command of the system (Debian: harminv)
  bench_venv=$root/build/bench/rivals bench_packages=$bench/records/requirements.txt
  ;;
sum) target=bench_sum ;;
throughput) if command -v mpifort > /dev/null && command -v mpirun > /dev/null; then target=beamwave-mpi; fi ;;
esac

lock
set_up default --target programs ${target:+"$target"}
mkdir -p "$bench_venv"
set_up_bench_python
unlock
exec "$bench_venv/bin/python" -m common "$name" "$@"
