"""What benches share; with it the helpers of tests/scenes and tests/reference are found."""

import sys
from pathlib import Path

sys.path += [str(Path(__file__).parents[2] / "tests" / folder) for folder in ("scenes", "reference")]
