#!/usr/bin/env bash
# missing_tools_are_named.sh SOURCE: where tools are missing and packages cannot be installed, run.sh
# and test.sh name what is missing and stop with status 1.
set -eu

source=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# a machine with a shell and little else
mkdir -p "$scratch/bin" "$scratch/src/cmake" "$scratch/postproc"
for tool in bash cat cksum dirname env find grep id mkdir printf rm sed sort; do
  ln -s "$(type -P "$tool")" "$scratch/bin/$tool"
done
touch "$scratch/CMakeLists.txt"
cp "$source/run.sh" "$source/test.sh" "$scratch"
cp "$source/src/cmake/setup.sh" "$scratch/src/cmake"

for script in run.sh test.sh; do
  status=0
  PATH=$scratch/bin FC='' CC='' "$scratch/$script" 2> "$scratch/messages" < /dev/null || status=$?
  cat "$scratch/messages"
  [ "$status" -eq 1 ] || { echo "$script: status $status, expected 1"; exit 1; }
  grep -q 'missing: a Fortran compiler (gfortran), a C compiler (cc), CMake 3.21 or newer, make$' "$scratch/messages"
done
