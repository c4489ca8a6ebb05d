# shellcheck shell=bash
# Sourced by the commands in bench/: the project's set-up, and a Python of the benches' own with the packages that
# bench/requirements.txt names; a bench may set both as its own, bench_venv and bench_packages. Nothing is installed into the
# system's Python; a second call installs nothing.
. "$(dirname -- "${BASH_SOURCE[0]}")/../../src/cmake/setup.sh"

bench=$root/bench
bench_venv=$root/build/bench/venv
bench_packages=$bench/requirements.txt
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

# run_bench MODULE [ARGUMENT …]: builds the program, and the target bench_target where a bench sets it, then runs the bench
run_bench() {
  lock
  set_up default --target programs ${bench_target:+"$bench_target"}
  mkdir -p "$bench_venv"
  set_up_bench_python
  unlock
  exec "$bench_venv/bin/python" -m "$@"
}
