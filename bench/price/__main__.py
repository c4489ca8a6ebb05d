"""What accuracy costs on scenes with a long record and a short one."""

import sys

from common.command import main

from .bench import BENCH

sys.exit(main(BENCH))
