#!/bin/bash
# A directory of records, repeats of one measurement, analysed on many cores into one result:
#
#   sbatch --ntasks=8 jobs/records.sh SCENE.nml DIRECTORY [--output DIR]
#
# SCENE.nml has a &record without `file`. The files of DIRECTORY, in the order of their names, are written into a copy of it,
# DIRECTORY/SCENE.nml, which is what runs: each file is a case. The same command once more goes on from what is finished.
#SBATCH --job-name=beamwave
#SBATCH --ntasks=4
#SBATCH --time=01:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --output=%x-%j.log

# module load gcc openmpi openblas fftw minpack netcdf-fortran
set -eu
export OPENBLAS_NUM_THREADS=1

scene=${1:?records.sh: a scene with a &record is missing}
directory=${2:?records.sh: a directory of records is missing}
shift 2

files=()
for file in "$directory"/*; do
  name=${file##*/}
  if [ -f "$file" ] && [ "${name##*.}" != nml ]; then files+=("'${name//\'/\'\'}'"); fi
done
[ ${#files[@]} -gt 0 ] || { echo "records.sh: no records in $directory" >&2; exit 2; }
# behind the name of the group, which may end on the same line; through a pipe, since an argument holds some thousands of names only
copy=$directory/${scene##*/}
text=$(printf '%s\n' "${files[@]}" | awk '
  NR == FNR { names[NR] = $0; count = NR; next }
  !done && match(tolower($0), /^[ \t]*&record([ \t\r\/!]|$)/) {
    place = index($0, "&") + 7
    print substr($0, 1, place - 1) " file ="
    for (i = 1; i <= count; i++) print "    " names[i] (i < count ? "," : "")
    $0 = substr($0, place)
    done = 1
  }
  { print }
  END { exit !done }' - "$scene") || { echo "records.sh: no line of $scene begins with &record" >&2; exit 2; }
[ "$(cat "$copy" 2> /dev/null)" = "$text" ] || printf '%s\n' "$text" > "$copy"
exec mpirun beamwave-mpi run "$copy" "$@"
