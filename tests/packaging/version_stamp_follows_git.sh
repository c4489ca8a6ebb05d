#!/usr/bin/env bash
# version_stamp_follows_git.sh SOURCE CMAKE: the commit in the version module is that of the checkout,
# with `+` for changes of its files and for new sources, whatever else lies in it, and `unknown` outside a repository; an
# unchanged stamp is not touched.
set -eu

source=$1 cmake=$2
git --version > /dev/null 2>&1 || { echo 'no git here: skipped'; exit 77; }
unset "${!GIT_@}"  # a hook runs the tests with the place of its own repository
scratch=$(cd -P -- "$(mktemp -d)" && pwd)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
mkdir checkout

stamp() {
  "$cmake" -D "SOURCE=$1" -D "TEMPLATE=$source/src/base/bw_version.f90.in" -D "OUTPUT=$scratch/stamp.f90" \
    -D PROJECT_VERSION=1.2.3 -D NATIVE=ON -D BEAMWAVE_BUILD=Release -D BEAMWAVE_LIBRARIES=none \
    -P "$source/src/cmake/stamp_version.cmake"
}

# expect COMMIT [SOURCE]
expect() {
  stamp "${2:-$scratch/checkout}"
  grep -q "program_commit = '$1'" stamp.f90 || { echo "expected $1, not"; grep program_commit stamp.f90; exit 1; }
}

in_checkout() { git -C checkout -c user.name=nobody -c user.email=nobody -c commit.gpgsign=false "$@" > /dev/null 2>&1; }

expect unknown
in_checkout init
expect unknown
echo one > checkout/file
in_checkout add file
in_checkout commit -m one
commit=$(git -C checkout rev-parse --short=12 HEAD)
expect "$commit"

touch -d '2000-01-01' stamp.f90
expect "$commit"
[ stamp.f90 -ot checkout/file ] || { echo 'an unchanged stamp was written again'; exit 1; }

echo two > checkout/file
expect "$commit+"
in_checkout checkout file
echo '&beam /' > checkout/scene.nml
mkdir checkout/output
echo 1 > checkout/output/scene.nc
expect "$commit"
mkdir -p checkout/src/new
for source_file in src/new/module.f90 CMakeLists.txt; do
  echo 1 > "checkout/$source_file"
  expect "$commit+"
  rm "checkout/$source_file"
  expect "$commit"
done
mkdir checkout/unpacked
expect unknown "$scratch/checkout/unpacked"
if [ "$(id -u)" -eq 0 ]; then
  chown -R 65534 checkout
  expect "$commit"
fi
