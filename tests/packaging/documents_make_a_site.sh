#!/usr/bin/env bash
# documents_make_a_site.sh SOURCE PYTHON: MkDocs makes the site without a warning, and no page of it loads anything from elsewhere.
set -eu
source=$1 python=$2
"$python" -c 'import mkdocs' 2> /dev/null || { echo 'no mkdocs in this Python'; exit 77; }
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
PYTHON=$python "$source/docs/site.sh" "$dir"
for page in index.html docs/tutorial.html docs/input.html postproc/index.html; do
  [ -s "$dir/site/$page" ] || { echo "not made: $page"; exit 1; }
done
if grep -rE '<(script|img)[^>]*src="(https?:)?//|<link[^>]*stylesheet[^>]*href="(https?:)?//' "$dir/site" --include='*.html'; then
  echo 'these pages load what is elsewhere'
  exit 1
fi
