"""Which points of the beam a picture of histories or spectra shows."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .result import NothingToDraw

MAX_PANELS = 4
SAME_POINT = 1e-9  # positions are typed as decimals; two that differ by less are one point


def chosen_points(ds: xr.Dataset, position: float | None = None) -> list[int]:
    """Indices of the point at `position` ξ, or of all points (at most `MAX_PANELS`, spread evenly).

    Raises `NothingToDraw` where the result has no point at `position`.
    """
    positions = ds["point_position"].values
    if position is not None:
        near = np.flatnonzero(np.abs(positions - position) < SAME_POINT)
        if not near.size:
            raise NothingToDraw(f"the result has no point at {position:g}")
        return [int(near[0])]
    count = min(positions.size, MAX_PANELS)
    return [int(i) for i in np.unique(np.linspace(0, positions.size - 1, count).round())]
