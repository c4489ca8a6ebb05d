#!/usr/bin/env bash
# bench/contact.sh [--small] [--redraw] [--output DIR]   error against seconds of a contact that lasts, beside OpenSees and Exudyn
set -eu
. "$(dirname -- "$0")/common/run.sh"
run_bench contact "$@"
