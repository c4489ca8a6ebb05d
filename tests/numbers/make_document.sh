#!/bin/sh
# make_document.sh PROGRAM DOCUMENT COMPILER LIBRARIES
# Measures the hard cases and puts their table into DOCUMENT, between its two marks, or makes the document.
set -eu
program=$1 document=$2 compiler=$3 libraries=$4
first='<!-- hard cases: numbers_document writes from here -->'
last='<!-- to here -->'

table=$("$program") || {
  printf '%s\n' "$table" 'a bound is missed' >&2
  exit 1
}

processor() {
  sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2> /dev/null | sed 1q | grep . || uname -m
}

section() {
  cat << END
$first
## Hard cases

Made by \`cmake --build --preset default --target numbers_document\`, after \`cmake --preset default\`. Errors are against references of
50 digits or more, computed from the same binary64 inputs ([tests/reference](../tests/reference/README.md)). The last column says how
many numbers were compared. \`./test.sh\` prints the table anew, optimised and with floating-point traps, and fails if a bound is
exceeded.

Measured on $(processor), $(uname -s), with $compiler, $libraries and the flags of the preset \`default\`.

$table
$last
END
}

[ -f "$document" ] || printf '%s\n\n%s\n%s\n' '# Numbers' "$first" "$last" > "$document"
section > "$document.new"
awk -v first="$first" -v last="$last" -v section="$document.new" '
  $0 == first { while ((getline line < section) > 0) print line; inside = 1 }
  !inside
  $0 == last { inside = 0 }' "$document" > "$document.whole"
mv "$document.whole" "$document"
rm "$document.new"
