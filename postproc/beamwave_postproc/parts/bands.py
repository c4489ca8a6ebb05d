"""Many cases that no order puts side by side, as those of a design: the bands in which they lie."""

from __future__ import annotations

import warnings

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from ..result import swept_inputs
from ..style import COLOURS, MAX_CURVES
from .curves import is_grid

# Share of the cases that each band holds, the widest first, and its colour.
BANDS = ((1.0, "all cases", "#DCE9F3"), (0.9, "9 of 10", "#AFCFE6"), (0.5, "half of them", "#77B0D6"))


def is_scattered(ds: xr.Dataset) -> bool:
    """Whether there are more cases than curves can be told apart, which vary several inputs at once and are no grid of them."""
    if ds.sizes.get("case", 1) <= MAX_CURVES:
        return False
    names = [name for name in swept_inputs(ds) if np.unique(ds[name]).size > 1]
    return len(names) > 1 and not is_grid(ds, names)


def draw_bands(axes: Axes, x: np.ndarray, values: np.ndarray) -> None:
    """Draw quantiles over the cases of `values` (case, x) at each x: bands and the median, all of them in the legend."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # where no case has a number, there is none
        for share, words, colour in BANDS:
            low, high = np.nanquantile(values, [0.5 - share / 2.0, 0.5 + share / 2.0], axis=0)
            axes.fill_between(x, low, high, color=colour, linewidth=0.0, label=words)
        axes.plot(x, np.nanmedian(values, axis=0), color=COLOURS[0], linewidth=1.1, label="median")
