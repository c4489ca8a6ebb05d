#!/bin/sh
# docs/site.sh [DIR]: makes the documents a web site in DIR/site (build/site), with the scenes, scripts and pictures that they link to.
# PYTHON names a Python that has mkdocs; else that of .venv.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
dir=${1:-$root/build}
python=${PYTHON:-$root/.venv/bin/python}
rm -rf "$dir/pages"
mkdir -p "$dir/pages"
dir=$(cd "$dir" && pwd)
cd "$root"
tar cf - --exclude=__pycache__ README.md CHANGELOG.md CONTRIBUTING.md CITATION.cff LICENSE docs input jobs postproc/README.md \
  bench/README.md tests/README.md tests/reference/README.md | tar xf - -C "$dir/pages"
BEAMWAVE_PAGES=$dir/pages exec "$python" -m mkdocs build --strict --config-file docs/mkdocs.yml --site-dir "$dir/site"
