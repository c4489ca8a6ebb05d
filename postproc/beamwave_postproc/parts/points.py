"""Which points of the beam a picture of histories or spectra shows, one panel each."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .labels import axis_label
from .select import spread
from .sheet import Given, Sheet, sheet_for

MAX_POINTS = 6
FEW = 3  # panels up to which the figure stays on a screen at full height


def shown_points(ds: xr.Dataset, limit: int = MAX_POINTS) -> list[int]:
    """Indices of all points, or of `limit` of them spread evenly."""
    return [int(i) for i in spread(ds.sizes["point"], limit)]


def sheet_of_points(ax: Given, rows: int, columns: int) -> Sheet:
    """Axes with a row for each point, as high as the words beside it need, and a column for each panel of cases."""
    height = 3.6 if rows == 1 else 2.4 if rows <= FEW else 1.8
    return sheet_for(ax, rows, columns, width=6.4 if columns == 1 else 3.4 * columns + 0.6, height=height, share="x")


def point_label(ds: xr.Dataset, name: str, point: int, prefix: str = "") -> str:
    """Label of variable `name` at one point, in two lines: neighbours do not meet."""
    return f"{axis_label(ds[name], prefix)}\n" + rf"at $\xi$ = {float(ds['point_position'][point]):.4g}"


def thinned(ds: xr.Dataset, points: list[int]) -> str:
    """Words for how many of the points are drawn; empty where all are."""
    count = ds.sizes["point"]
    return f"{len(points)} of {count} points" if len(points) < count else ""


def error_note(ds: xr.Dataset, cases: list[xr.Dataset], name: str, points: list[int]) -> str:
    """The largest estimated error, over the peak at its point, and where that is; empty without estimates."""
    worst, where = 0.0, 0
    for case in cases:
        if f"{name}_error" not in case:
            return ""
        for point in points:
            peak = np.nanmax(np.abs(case[name][point].values), initial=0.0)
            error = float(case[f"{name}_error"][point])
            if peak > 0.0 and np.isfinite(error) and error / peak > worst:
                worst, where = error / peak, point
    if not worst:
        return ""
    place = rf"at $\xi$ = {float(ds['point_position'][where]):.4g}"
    single = len(cases) == 1 and len(points) == 1
    return f"estimated error {percent(worst)} of the peak {place}" + ("" if single else ", the largest here")


def percent(share: float) -> str:
    """A share to two digits, in per cent unless it is very small."""
    return f"{float(f'{100.0 * share:.2g}'):g} %" if share >= 1e-4 else f"{share:.1e}"
