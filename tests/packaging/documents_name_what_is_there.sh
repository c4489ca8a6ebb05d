#!/usr/bin/env bash
# documents_name_what_is_there.sh SOURCE: every file and folder that the documents name is there, and docs/code.md shows every room
# of src/, with the arrows that the build holds to.
set -eu

cd "$1"
failed=0
wrong() {
  echo "$*"
  failed=1
}

# what of a document is a path: a link, or one word between backquotes that is a source file or begins with a folder of the
# repository or of src/; `<effect>` stands for a name, and names nothing
rooms=$(sed -n 's/^foreach(room IN ITEMS \(.*\))$/\1/p' src/CMakeLists.txt)
folders=$(printf '%s|' src tests docs input bench jobs postproc $rooms)
paths_in() {
  grep -o ']([^)#:]*[)#]' "$1" | sed 's/^](//; s/.$//'
  grep -o '`[^` <>*…$]*`' "$1" | tr -d '`' | grep -E "^((${folders%|})/.*|[^ ]*/[^/]+\.(f90|c|pf|py|sh|cmake)|bw_[a-z_0-9]+\.(f90|c))$"
}
for document in README.md docs/*.md docs/method/*.md tests/README.md tests/reference/README.md bench/README.md postproc/README.md; do
  while read -r path; do
    [ -e "$(dirname "$document")/$path" ] || [ -e "$path" ] || [ -e "src/$path" ] ||
      wrong "$document: $path is not there"
  done < <(paths_in "$document" | sort -u)
done

# the map has a row for each folder with sources
while read -r folder; do
  grep -q "^| \`$folder/\` |" docs/code.md || wrong "docs/code.md: $folder/ is not in the map"
done < <(find src -name '*.f90' -o -name '*.c' -o -name '*.cmake' | sed 's,/[^/]*$,,' | sort -u)

# the arrows
arrows=$(printf '%s\n' $rooms | tac | paste -sd ' ' | sed 's/ / ► /g')
grep -qxF "\`$arrows\`" docs/code.md || wrong "docs/code.md: its arrows are not those of src/CMakeLists.txt, $arrows"
exit $failed
