"""Instructions and seconds of the paper's scene with each effect added alone."""

import sys

from common.command import main

from .bench import BENCH

sys.exit(main(BENCH))
