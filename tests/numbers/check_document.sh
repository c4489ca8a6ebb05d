#!/bin/sh
# check_document.sh TABLE DOCUMENT: every case of the table, with its bound, stands in the document.
awk -F '|' '
  function cell(text) { gsub(/^ +| +$/, "", text); return text }
  NF < 5 { next }
  FNR == NR { documented[cell($2) "|" cell($4)]; next }
  { cases++ }
  !((cell($2) "|" cell($4)) in documented) {
    print "not in the document: " cell($2) ", bound " cell($4)
    lacking = 1
  }
  END {
    if (lacking) print "cmake --build --preset default --target numbers_document writes it anew"
    exit lacking || !cases
  }' "$2" "$1"
