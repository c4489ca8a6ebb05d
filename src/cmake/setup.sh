# shellcheck shell=bash
# Sourced by run.sh and test.sh: makes sure that what they need is there, then builds.
#
# What a machine lacks is found by trying it: a compiler compiles, CMake runs and configures. Nobody
# asks a package manager, so modules, conda and Spack pass. Only then are Debian packages installed,
# and where that cannot be done the names of what is missing are printed and the script stops.
# Nothing is ever asked. Messages go to standard error; the details of each step to build/setup/.

root=$(unset CDPATH; cd -P -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
setup=$root/build/setup
python=$root/.venv/bin/python
missing=()   # what the machine lacks, by its common names
packages=()  # the Debian packages that bring it

# a process uses one thread: OpenBLAS would start one per core
export OPENBLAS_NUM_THREADS=1
export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-2}

say() { printf 'beamwave: %s\n' "$*" >&2; }

die() {
  say "$@"
  exit 1
}

# logged STEP COMMAND …: runs a command with its output in build/setup/STEP.log
logged() {
  local log=$setup/$1.log
  shift
  "$@" > "$log" 2>&1 < /dev/null
}

show_log() { sed 's/^/  /' "$setup/$1.log" >&2; }

# lock, unlock: one call at a time writes in a checkout. Where there is no flock nobody waits.
# The lock is file descriptor 9: what may outlive the script is started with 9>&-
lock() {
  if ! { mkdir -p "$setup" && [ -w "$root" ] && [ -w "$setup" ]; } 2> /dev/null; then
    die "cannot write in $root: use a checkout of your own, or build elsewhere: cmake -S '$root' -B DIRECTORY"
  fi
  exec 9> "$setup/lock"
  flock --version > /dev/null 2>&1 || return 0
  flock --nonblock 9 && return
  say 'another run.sh or test.sh is at work in this checkout: waiting for it'
  flock 9
}

unlock() { exec 9>&-; }

# --- what is left behind ----------------------------------------------------------------------------

scratch=  # a directory that lives no longer than the script

# leave_nothing: whatever ends this script, also kill -9, what it has made and started in `scratch` and `in_group` ends with it.
# Another process sees to that, which waits for the end of file descriptor 8. Where there is no setsid nothing is seen to.
leave_nothing() {
  { setsid --version && mktemp --version; } > /dev/null 2>&1 || return 0
  scratch=$(mktemp -d)
  exec 8> >(exec setsid bash "$root/src/cmake/clean_up.sh" "$scratch" > /dev/null 2>&1 8>&- 9>&-)
}

# removed_at_end FILE …: to be removed when the script ends, if not before
removed_at_end() { [ -z "$scratch" ] || printf '%s\n' "$@" >> "$scratch/files"; }

# in_group COMMAND …: runs a command that ends with this script, as does all that it starts
in_group() {
  if [ -z "$scratch" ]; then
    "$@" 9>&-
    return
  fi
  local status=0
  setsid "$@" 8>&- 9>&- < /dev/null &
  echo $! > "$scratch/group"
  wait $! || status=$?
  rm -f "$scratch/group"
  return "$status"
}

# --- what is missing -------------------------------------------------------------------------------

# need WHAT PACKAGE PROBE …: remembers WHAT and the PACKAGE that brings it unless PROBE succeeds
need() {
  local what=$1 package=$2
  shift 2
  if ! "$@"; then
    missing+=("$what")
    packages+=("$package")
  fi
}

compiler_compiles() {
  printf 'program probe\n  use, intrinsic :: iso_fortran_env, only: real128\nend program probe\n' > "$setup/probe.f90"
  # FC may carry flags of its own, as CMake allows
  # shellcheck disable=SC2086
  logged compiler ${FC:-gfortran} "$setup/probe.f90" -o "$setup/probe" && logged compiler "$setup/probe"
}

c_compiles() {
  echo 'int main(void) { return 0; }' > "$setup/probe.c"
  # shellcheck disable=SC2086
  logged compiler-c ${CC:-cc} "$setup/probe.c" -o "$setup/probe" && logged compiler-c "$setup/probe"
}

cmake_runs() {
  echo 'cmake_minimum_required(VERSION 3.21)' > "$setup/probe.cmake"
  logged cmake cmake -P "$setup/probe.cmake"
}

build_tool_runs() {
  case ${CMAKE_GENERATOR:-} in
    Ninja*) logged make ninja --version ;;
    *) logged make make --version ;;
  esac
}

# the libraries are looked for by CMake alone, which lists those it lacks
cmake_found() { ! grep -q "^ *$1 (" "$setup/configure.log"; }

# what CMake needs before it can look for libraries
find_tools() {
  need "a Fortran compiler (${FC:-gfortran})" gfortran compiler_compiles
  need "a C compiler (${CC:-cc})" gcc c_compiles
  need 'CMake 3.21 or newer' cmake cmake_runs
  need 'make' make build_tool_runs
}

find_libraries() {
  need 'NetCDF-Fortran' libnetcdff-dev cmake_found NetCDF-Fortran
  need 'FFTW 3' libfftw3-dev cmake_found 'FFTW 3'
  need 'MINPACK' minpack-dev cmake_found MINPACK
  need 'LAPACK' libopenblas-serial-dev cmake_found LAPACK  # serial: one thread, whatever the environment says
}

# --- installing ------------------------------------------------------------------------------------

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo -n "$@"; fi
}

# apt_install PACKAGE …: fails where packages cannot be installed without asking anybody
apt_install() {
  local apt=(env DEBIAN_FRONTEND=noninteractive apt-get -y -o DPkg::Lock::Timeout=600)
  command -v apt-get > /dev/null && as_root true 2> /dev/null || return
  say "installing Debian packages: $*"
  logged apt-update as_root "${apt[@]}" update || show_log apt-update
  logged apt-install as_root "${apt[@]}" install --no-install-recommends "$@" || { show_log apt-install; return 1; }
}

# installs what `need` found missing, or says what it is and stops
install_missing() {
  [ ${#missing[@]} -gt 0 ] || return 0
  say "missing: $(joined "${missing[@]}")"
  apt_install "${packages[@]}" ||
    die "packages cannot be installed from here: please provide what is missing (apt-get as root, modules, conda," \
      "Spack); what was tried is in $setup/*.log"
  missing=()
  packages=()
}

joined() {
  local text=$1
  shift
  [ $# -eq 0 ] || text+=$(printf ', %s' "$@")
  printf '%s' "$text"
}

# --- building --------------------------------------------------------------------------------------

# configure PRESET: a checkout that was copied or moved brings a cache that CMake refuses
configure() {
  local build=$root/build home
  [ "$1" = default ] || build=$root/build/$1
  home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt" 2> /dev/null) || true
  [ -z "$home" ] || [ "$home" -ef "$root" ] || rm -rf "$build/CMakeCache.txt" "$build/CMakeFiles"
  (cd "$root" && logged configure cmake --preset "$1")
}

# configured PRESET: configures, installing what is missing on the way
configured() {
  configure "$1" && return
  find_tools
  install_missing
  find_tools  # again: a package can be older than what is needed
  [ ${#missing[@]} -eq 0 ] || die "still missing: $(joined "${missing[@]}")"
  configure "$1" && return
  find_libraries
  install_missing
  configure "$1" && return
  show_log configure
  die "CMake could not configure the preset $1"
}

# set_up PRESET [ARGUMENT …]: configures and builds this preset; arguments go to `cmake --build`
set_up() {
  configured "$1"
  # not in a subshell, which would outlive a killed script and hold its file descriptors
  in_group bash -c 'cd -- "$1" && shift && exec cmake --build --preset "$@"' build "$root" "$@" >&2 || die "the preset $1 did not build"
}

# --- Python ----------------------------------------------------------------------------------------

# a sum of all that an installed beamwave_postproc is made of; its version is the one of CMakeLists.txt
postproc_sum() {
  (cd "$root" && find CMakeLists.txt postproc -type f ! -path '*/__pycache__/*' ! -path postproc/tests/'*' \
    -exec cksum {} + | sort | cksum)
}

# set_up_python MODULES [EXTRA]: .venv with beamwave_postproc as it is now (and its extra), so that
# MODULES can be imported. Fails where there is no Python, which costs the figures and nothing else.
set_up_python() {
  local modules=$1 extra=${2:-} sum stamp=$root/.venv/postproc.sum
  sum=$(postproc_sum)
  [ "$(cat "$stamp" 2> /dev/null)" = "$sum" ] && "$python" -c "import $modules" 2> /dev/null && return
  make_venv || return
  say 'installing beamwave_postproc and what it needs into .venv'
  logged pip env PIP_USER=0 "$python" -m pip install "$root/postproc$extra" || { show_log pip; return 1; }
  echo "$sum" > "$stamp"
}

make_venv() {
  "$python" -m pip --version > /dev/null 2>&1 && return
  logged venv python3 -m venv --clear "$root/.venv" && return
  apt_install python3 python3-venv && logged venv python3 -m venv --clear "$root/.venv" && return
  say 'missing: Python 3 with venv'
  return 1
}
