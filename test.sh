#!/usr/bin/env bash
# ./test.sh [ARGUMENT …]   builds and runs every test, optimised and with all run-time checks; what is
# given goes to CTest: ./test.sh -L unit, ./test.sh -R capture
set -eu
. "$(dirname -- "$0")/src/cmake/setup.sh"

presets=(default dev)

lock
left_out=
set_up_python beamwave_postproc,pytest '[test]' || left_out='no Python: the tests that need it were left out'
for preset in "${presets[@]}"; do
  set_up "$preset"
done

export CTEST_PARALLEL_LEVEL=${CTEST_PARALLEL_LEVEL:-2}
cd "$root"
failed=()
for preset in "${presets[@]}"; do
  say "testing the preset $preset"
  ctest --preset "$preset" --no-tests=error "$@" 9>&- || failed+=("$preset")
done
[ -z "$left_out" ] || say "$left_out"
[ ${#failed[@]} -eq 0 ] || die "tests failed in: $(joined "${failed[@]}")"
