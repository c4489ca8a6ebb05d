#!/usr/bin/env bash
# installed_program_reads_installed_scenes.sh BUILD CMAKE: `cmake --install` puts program, scenes and
# documents where they belong, and the program works from there.
set -eu

build=$1 cmake=$2
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT

"$cmake" --install "$build" --prefix "$prefix" > /dev/null
for file in share/beamwave/{input/paper/fig2.nml,jobs/single.sh} share/doc/beamwave/{README.md,LICENSE,docs/input.md} \
  share/man/man{1/beamwave.1,5/beamwave.5} share/{bash-completion/completions/beamwave,zsh/site-functions/_beamwave}; do
  [ -s "$prefix/$file" ] || { echo "not installed: $file"; exit 1; }
done
"$prefix/bin/beamwave" --version
"$prefix/bin/beamwave" check "$prefix/share/beamwave/input/paper"
command -v pkg-config > /dev/null || exit 0
export PKG_CONFIG_PATH="$prefix/share/pkgconfig"
"$(pkg-config --variable=bindir beamwave)/beamwave" check "$(pkg-config --variable=input beamwave)/spectrum.nml"
