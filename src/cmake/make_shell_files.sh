#!/bin/sh
# make_shell_files.sh PROGRAM DIR VERSION: man pages and completions from what the program says of itself, by --help and describe.
# Writes DIR/man/beamwave.1, DIR/man/beamwave.5, and DIR/complete/ for bash, zsh (_beamwave) and fish.
set -eu
program=$1 dir=$2 version=$3
mkdir -p "$dir/man" "$dir/complete"
help=$("$program" --help)

# --- man pages ---

roff() { sed 's/\\/\\e/g; s/-/\\-/g; s/^\([.'\'']\)/\\\&\1/'; }

{
  printf '.TH BEAMWAVE 1 "" "beamwave %s"\n.SH NAME\nbeamwave \\- bending waves in beams that are struck\n.SH SYNOPSIS\n.nf\n' "$version"
  printf '%s\n' "$help" | sed -nE 's/^  ((beamwave|mpirun) [^ ]*( [^ ]+)*)  .*/\1/p' | roff
  printf '.fi\n.SH DESCRIPTION\n.nf\n'
  printf '%s\n' "$help" | roff
  printf '.fi\n.SH FILES\nA scene, SCENE.nml, is described in\n.BR beamwave (5).\nIts result is output/SCENE.nc, a NetCDF file.\n'
} > "$dir/man/beamwave.1"

# the Markdown of `describe`: a heading, paragraphs, lists, fenced blocks and tables
{
  printf '.TH BEAMWAVE 5 "" "beamwave %s"\n.SH NAME\nbeamwave \\- scenes, the input of beamwave(1)\n.SH DESCRIPTION\n' "$version"
  "$program" describe | roff | awk '
    function trimmed(text) { gsub(/^ +| +$/, "", text); gsub(/`/, "", text); return text }
    /^```/ { fenced = !fenced; print fenced ? ".PP\n.nf" : ".fi"; next }
    fenced { print; next }
    /^# / { next }
    /^## / { gsub(/`/, ""); print ".SH " substr($0, 4); next }
    /^\| *(name|effect|:?\\-)/ || /^\| \\-/ { next }
    /^\|/ {
      if (split($0, cell, "|") < 8) { print ".TP\n.B " trimmed(cell[2]) "\n" trimmed(cell[3]); next }
      print ".TP\n.B " trimmed(cell[2]) "\n" trimmed(cell[7]) "; " trimmed(cell[3]) ", unit " trimmed(cell[4]) ", range " \
        trimmed(cell[5]) ", default " trimmed(cell[6])
      next
    }
    /^$/ { print ".PP"; next }
    /^\\- / { gsub(/`/, ""); print ".IP \\(bu 2\n" substr($0, 4); next }
    { sub(/^ +/, ""); gsub(/`/, ""); print }'
} > "$dir/man/beamwave.5"

# --- completions ---

commands=$(printf '%s\n' "$help" | sed -n 's/^  beamwave \([a-z]\{1,\}\) .*/\1/p' | tr '\n' ' ')
options=$(printf '%s\n' "$help" | sed -n 's/^    \(--[a-z-]*\) .*/\1/p' | tr '\n' ' ')
groups=$("$program" describe | sed -n 's/^## &//p' | tr '\n' ' ')
# which command takes which options, a line each: `run --output --overwrite`
taken=$(printf '%s\n' "$help" | sed -nE '/^  [a-z].* takes? /p' | tr ';' '\n' | awk -v all="$options" '
  { taken = ""; n = 0; seen = 0
    for (i = 1; i <= NF; i++)
      if ($i ~ /^takes?$/) seen = 1
      else if (!seen && $i != "and") names[++n] = $i
      else if ($i ~ /^--/) taken = taken " " $i
    for (i = 1; i <= n; i++) print names[i] (taken == "" ? " " all : taken) }')

{
  printf '# bash completion of beamwave\n_beamwave() {\n  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} words=\n'
  printf '  COMPREPLY=()\n  if [ "$COMP_CWORD" -eq 1 ]; then\n    words="%s--help --version"\n' "$commands"
  printf '  elif [ "$previous" = --output ]; then\n    mapfile -t COMPREPLY < <(compgen -d -- "$word")\n    return\n'
  printf '  elif [ "$previous" = --max-seconds ] || [ "$previous" = --part ]; then\n    return\n  else\n    case ${COMP_WORDS[1]} in\n'
  printf '%s\n' "$taken" | while read -r name all; do printf '      %s) words="%s" ;;\n' "$name" "$all"; done
  printf '      describe) words="%s" ;;\n    esac\n  fi\n' "$groups"
  printf '  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")\n'
  printf '  [ "$COMP_CWORD" -eq 1 ] || [ "${COMP_WORDS[1]}" = describe ] ||\n'
  printf '    mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -d -- "$word"; compgen -f -X "!*.nml" -- "$word")\n}\n'
  printf 'complete -o filenames -F _beamwave beamwave beamwave-mpi\n'
} > "$dir/complete/beamwave"

{
  printf '#compdef beamwave beamwave-mpi\n# zsh completion of beamwave\nif (( CURRENT == 2 )); then\n  compadd %s--help --version\nelse\n' "$commands"
  printf '  case ${words[2]} in\n'
  printf '%s\n' "$taken" | while read -r name all; do
    printf '    %s) [[ $PREFIX == -* ]] && compadd -- %s || _files -g "*.nml" ;;\n' "$name" "$all"
  done
  printf '    describe) compadd %s;;\n  esac\nfi\n' "$groups"
} > "$dir/complete/_beamwave"

{
  printf '# fish completion of beamwave\ncomplete -c beamwave -n __fish_use_subcommand -f -a "%s--help --version"\n' "$commands"
  printf '%s\n' "$taken" | while read -r name all; do
    for option in $all; do
      printf 'complete -c beamwave -n "__fish_seen_subcommand_from %s" -l %s\n' "$name" "${option#--}"
    done
  done
  printf 'complete -c beamwave -n "__fish_seen_subcommand_from describe" -f -a "%s"\n' "$groups"
} > "$dir/complete/beamwave.fish"
