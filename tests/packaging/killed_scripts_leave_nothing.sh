#!/usr/bin/env bash
# killed_scripts_leave_nothing.sh SOURCE: whatever ends .ci/run while it builds or tests, nothing is left of it: no process, no
# file beside those in the build directory of the checkout.
# shellcheck disable=SC2016  # what stands in single quotes here is expanded elsewhere
set -eu

setsid --version > /dev/null 2>&1 || exit 77

source=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
checkout=$scratch/checkout
mkdir -p "$checkout/src/cmake" "$checkout/.ci" "$checkout/postproc" "$scratch/bin" "$scratch/tmp"
cp "$source/test.sh" "$checkout"
cp "$source/src/cmake/"*.sh "$checkout/src/cmake"
sed "s|^policy=/usr|policy=$scratch/tmp|" "$source/.ci/run" > "$checkout/.ci/run"
mkdir -p "$scratch/tmp/sbin"
chmod +x "$checkout/.ci/run"

# tools that do nothing; one of them, named by STUCK, starts a process in the background, makes a file and does not end
cat > "$scratch/bin/stub" << 'STUB'
#!/usr/bin/env bash
[ "${0##*/}" = "$STUCK" ] || exit 0
case " $* " in *--version* | " --preset "*) [ "$STUCK" = ctest ] || exit 0 ;; esac  # cmake is to build
echo $$ >> "$PIDS"
touch "${TMPDIR:-/tmp}/of_a_test"
sleep 1000 &
echo $! >> "$PIDS"
echo ready >> "$PIDS"
wait
STUB
chmod +x "$scratch/bin/stub"
for tool in apt-get cmake ctest gfortran mpifort mpirun python3 sudo; do ln -s stub "$scratch/bin/$tool"; done

alive() {  # a process that nobody has waited for yet is dead all the same
  [ -r "/proc/$1/stat" ] && ! grep -q ') Z ' "/proc/$1/stat" 2> /dev/null
}

within() {  # within SECONDS COMMAND …: until it succeeds
  local i seconds=$1
  shift
  for ((i = 0; i < 10 * seconds; i++)); do
    "$@" && return
    sleep 0.1
  done
  return 1
}

all_gone() {
  local pid
  while read -r pid; do
    if [ "$pid" != ready ] && alive "$pid"; then return 1; fi
  done < "$PIDS"
  [ -z "$(find "$scratch/tmp" -type f)" ]
}

export PIDS=$scratch/pids STUCK TMPDIR=$scratch/tmp
for STUCK in cmake ctest; do
  for signal in TERM HUP KILL; do
    : > "$PIDS"
    PATH=$scratch/bin:$PATH setsid "$checkout/.ci/run" > "$scratch/messages" 2>&1 < /dev/null &
    script=$!
    within 60 grep -q ready "$PIDS" || { cat "$scratch/messages"; echo "$STUCK is not reached"; exit 1; }
    kill -"$signal" "$script"
    wait "$script" || true
    within 60 all_gone || { ps -fp "$(grep -v ready "$PIDS" | paste -sd,)"; find "$scratch/tmp"; echo "$signal: something is left"; exit 1; }
  done
done
