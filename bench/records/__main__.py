"""Error, outliers, coverage and time of beamwave and other tools on the same noisy records."""

import sys

from common.command import main

from .bench import BENCH

sys.exit(main(BENCH))
