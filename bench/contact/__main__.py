"""Error against seconds of a contact that lasts, beamwave beside OpenSees and Exudyn."""

import sys

from common.command import main

from .bench import BENCH

sys.exit(main(BENCH))
