"""What benches share; with it postproc/ and the helpers of tests/scenes and tests/reference are found."""

import sys
from pathlib import Path

sys.path += [str(Path(__file__).parents[2] / folder) for folder in ("postproc", "tests/scenes", "tests/reference")]
