"""Which points of the beam a picture of histories or spectra shows."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from .labels import axis_label
from .result import NothingToDraw
from .style import new_figure

MAX_PANELS = 6
FEW = 3  # panels up to which the figure stays on a screen at full height
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


def panels_for(points: list[int]) -> Figure:
    """Return a figure with one panel per point, each as high as the words beside it need."""
    fig = new_figure(len(points), row_height=4.2 if len(points) == 1 else 2.8 if len(points) <= FEW else 2.0)
    fig.align_ylabels()
    return fig


def point_label(ds: xr.Dataset, name: str, point: int, prefix: str = "") -> str:
    """Label of variable `name` at one point, in two lines: neighbours do not meet."""
    return f"{axis_label(ds[name], prefix)}\n" + rf"at $\xi = {float(ds['point_position'][point]):.4g}$"


def thinned(ds: xr.Dataset, points: list[int]) -> str:
    """How many of the points are shown, where that is not all and more than one; else empty."""
    count = ds.sizes["point"]
    return f"{len(points)} of {count} points" if 1 < len(points) < count else ""
