"""Time and memory of a run against modes, samples and points."""

import sys

from common.command import main

from .bench import BENCH

sys.exit(main(BENCH))
