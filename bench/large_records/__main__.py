"""Time and memory of the lines of a record against its samples and sensors."""

import sys

from common.command import main

from .bench import BENCH

sys.exit(main(BENCH))
