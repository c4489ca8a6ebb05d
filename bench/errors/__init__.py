"""Random scenes, and how far the program's estimates and bounds are from the errors."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from common.bench import PROGRAM as BUILT

PROGRAM = Path(os.environ.get("BEAMWAVE", BUILT))
SEED = int(os.environ.get("BEAMWAVE_SEED", "1"))


def spread(ratios: list[float]) -> str:
    """What is said of estimates over errors."""
    least, median, most = np.quantile(ratios, [0, 0.5, 0.9])
    below = np.sum(np.less(ratios, 1))
    return (
        f"{len(ratios):5} histories, estimate over error: least {least:.2g}, median {median:.2g}, "
        f"nine tenths {most:.2g}; below 1: {below}"
    )
