#!/usr/bin/env bash
# shell_files_know_the_program.sh DIR PROGRAM: man pages that man reads without a warning name every command and every input, and bash,
# and zsh and fish where they are there, complete commands, options and groups.
set -eu
dir=$1 program=$2
failed=0
wrong() {
  echo "$*"
  failed=1
}
plain() { if command -v man > /dev/null; then MANWIDTH=100 man -P cat -l "$1" 2>&1 | sed 's/.\x08//g'; else sed 's/\\-/-/g; s/\\e/\\/g' "$1"; fi; }

commands=$("$program" --help | sed -n 's/^  beamwave \([a-z]*\) .*/\1/p')
options=$("$program" --help | sed -n 's/^    \(--[a-z-]*\) .*/\1/p')
[ -n "$commands" ] && [ -n "$options" ] || wrong 'the help shows no commands or options'
page=$(plain "$dir/man/beamwave.1")
for word in $commands $options; do [[ $page == *"$word"* ]] || wrong "beamwave.1 lacks $word"; done
page=$(plain "$dir/man/beamwave.5")
for name in $("$program" describe | sed -n 's/^## \(&[a-z_]*\)$/\1/p; s/^| `\([a-z_]*\)` .*/\1/p'); do
  [[ $page == *"$name"* ]] || wrong "beamwave.5 lacks $name"
done
[[ $page != *'| '* ]] || wrong 'beamwave.5 has rows of a table in it'
if command -v groff > /dev/null; then
  for file in "$dir"/man/*; do
    said=$(groff -man -Tutf8 -ww "$file" 2>&1 > /dev/null)
    [ -z "$said" ] || wrong "groff says of $file: $said"
  done
fi

# completed WORD …: what bash offers for the last of these words
completed() {
  bash -c '. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _beamwave; printf "%s\n" "${COMPREPLY[@]}"' - "$dir/complete/beamwave" "$@"
}
[ "$(completed beamwave de)" = describe ] || wrong "bash offers '$(completed beamwave de)' for 'de'"
[ "$(completed beamwave run --over)" = --overwrite ] || wrong "bash offers '$(completed beamwave run --over)' for 'run --over'"
[ "$(completed beamwave check --over)" = '' ] || wrong 'bash offers --overwrite for check'
[ "$(completed beamwave describe stif)" = stiffening ] || wrong "bash offers '$(completed beamwave describe stif)' for 'describe stif'"
for shell in bash zsh fish; do
  command -v "$shell" > /dev/null || continue
  case $shell in bash) file=beamwave ;; zsh) file=_beamwave ;; fish) file=beamwave.fish ;; esac
  "$shell" -n "$dir/complete/$file" || wrong "$shell does not read $file"
done
exit $failed
