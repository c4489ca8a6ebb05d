#!/usr/bin/env bash
# ./test.sh [ARGUMENT …]   builds and runs every test, optimised and with all run-time checks, and the fuzz of
# the scene reader with sanitizers; what is given goes to CTest: ./test.sh -L unit, ./test.sh -R contact
set -eu
. "$(dirname -- "$0")/src/cmake/setup.sh"

presets=(default dev)

# the sanitizers are libraries, which not every compiler comes with
can_sanitize() {
  echo end > "$setup/probe.f90"
  # FC may carry flags of its own, as CMake allows
  # shellcheck disable=SC2086
  logged sanitize ${FC:-gfortran} -fsanitize=address,undefined "$setup/probe.f90" -o "$setup/probe" &&
    logged sanitize "$setup/probe"
}

# beamwave-mpi is built where CMake finds MPI; its tests are reported as skipped elsewhere
mpi_compiles() {
  printf 'program probe\n  use mpi_f08\nend program probe\n' > "$setup/probe_mpi.f90"
  logged mpi mpifort "$setup/probe_mpi.f90" -o "$setup/probe_mpi" && logged mpi mpirun --version
}

lock
leave_nothing
[ -z "$scratch" ] || export TMPDIR=$scratch
left_out=
mpi_compiles || apt_install libopenmpi-dev openmpi-bin || say 'no MPI: its tests will be skipped'
without_sanitizers=
set_up_python beamwave_postproc,pytest,f90nml,mpmath,markdown_it,hatchling,mkdocs '[test]' || left_out='no Python: the tests that need it were left out'
for preset in "${presets[@]}"; do
  set_up "$preset"
done
if can_sanitize; then set_up sanitize --target fuzz; else without_sanitizers=yes; fi

# times_of_tests LOG: each test of the last run, the slowest first
times_of_tests() {
  awk '/^  [a-z_0-9]+: / { name = $0 } /^ +[0-9.]+ s$/ { print $1 " s" name }
    /s (call|setup) / { print }' "$1" | sort -rn
}

export CTEST_PARALLEL_LEVEL=${CTEST_PARALLEL_LEVEL:-3}  # kills, limits and job queues are waited for: room for one more
cd "$root"
failed=()
for preset in "${presets[@]}"; do
  say "testing the preset $preset"
  hard_cases=build/${preset#default}/tests/numbers/hard_cases.md  # what the test `numbers` measures
  rm -f "$hard_cases"
  in_group ctest --preset "$preset" --no-tests=error "$@" || failed+=("$preset")
  [ ! -f "$hard_cases" ] || cat "$hard_cases"
  times=build/${preset#default}/times.txt
  times_of_tests "build/${preset#default}/Testing/Temporary/LastTest.log" > "$times"
  say "the time of every test is in $times; of those that took a second and more:"
  awk '$1 + 0 >= 1' "$times"
done
if [ -z "$without_sanitizers" ]; then
  say 'testing the preset sanitize: the fuzz'
  in_group ctest --preset sanitize -L '^fuzz$' "$@" || failed+=(sanitize)
fi
[ -z "$without_sanitizers" ] || say 'the compiler has no sanitizers: the fuzz with them was left out'
[ -z "$left_out" ] || say "$left_out"
[ ${#failed[@]} -eq 0 ] || die "tests failed in: $(joined "${failed[@]}")"
