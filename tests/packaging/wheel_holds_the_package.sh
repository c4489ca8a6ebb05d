#!/usr/bin/env bash
# wheel_holds_the_package.sh SOURCE PYTHON VERSION: a wheel of beamwave_postproc, made without the network, installs by itself, has the
# version of the project and its commands, also by way of a source distribution. A copy of postproc/ alone makes a wheel, too.
set -eu
source=$1 python=$2 version=$3
"$python" -c 'import hatchling' 2> /dev/null || { echo 'no hatchling in this Python'; exit 77; }
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
make_wheel() { "$python" -m pip wheel --quiet --no-index --no-deps --no-build-isolation --wheel-dir "$1" "$2"; }
make_wheel "$dir" "$source/postproc"
wheel=$dir/beamwave_postproc-$version-py3-none-any.whl
[ -s "$wheel" ] || { ls "$dir"; echo "no wheel of version $version"; exit 1; }
"$python" -m pip install --quiet --no-index --no-deps --target "$dir/installed" "$wheel"
cd "$dir"
PYTHONPATH=$dir/installed "$python" - "$dir/installed" << 'END'
import sys
from importlib.metadata import entry_points
from pathlib import Path

import beamwave_postproc

assert Path(beamwave_postproc.__file__).is_relative_to(sys.argv[1]), beamwave_postproc.__file__
names = {point.name for point in entry_points(group="console_scripts")}
assert {"beamwave-plot", "beamwave-record", "beamwave-blade"} <= names, names
END
[ -e "$dir/installed/beamwave_postproc/py.typed" ] || { echo 'py.typed is missing'; exit 1; }

(cd "$source/postproc" && "$python" -m hatchling build --target sdist --directory "$dir/sdist" > /dev/null)
make_wheel "$dir/from_sdist" "$dir/sdist/beamwave_postproc-$version.tar.gz"
[ -s "$dir/from_sdist/${wheel##*/}" ] || { ls "$dir/from_sdist"; echo "no wheel of version $version from the source distribution"; exit 1; }

mkdir "$dir/copy"
cp -R "$source/postproc/README.md" "$source/postproc/"*.toml "$source/postproc/"*.py "$source/postproc/beamwave_postproc" "$dir/copy"
make_wheel "$dir/from_copy" "$dir/copy"
[ -s "$dir/from_copy/beamwave_postproc-0+unknown-py3-none-any.whl" ] || { ls "$dir/from_copy"; echo 'no wheel from a copy'; exit 1; }
