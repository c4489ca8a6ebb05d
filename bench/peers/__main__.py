"""Error against seconds, beamwave beside what else one could pick."""

import sys

from common.command import main

from .bench import BENCH

sys.exit(main(BENCH))
