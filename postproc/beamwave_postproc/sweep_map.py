"""Mode frequencies over a sweep of two inputs, as maps."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .labels import axis_label, input_label
from .result import NothingToDraw, require, require_numbers, swept_inputs, to_grid
from .style import new_figure, styled

MAX_MODES = 4


@styled
def sweep_map(ds: xr.Dataset) -> Figure:
    """Map `angular_frequency` (case, mode) of the lowest modes over the two swept inputs.

    The input that varies fastest runs along x. Where a mode does not oscillate the map is hatched.
    """
    require(ds, "angular_frequency")
    names = swept_inputs(ds)
    if len(names) != 2 or any(np.unique(ds[name]).size < 2 for name in names):
        raise NothingToDraw("the result is not a sweep of two inputs, each of two values or more")
    grid = to_grid(ds[["angular_frequency"]].isel(mode=slice(MAX_MODES)))
    require_numbers(grid["angular_frequency"].values, "angular_frequency")
    modes = grid["mode"].values
    columns = 1 if modes.size == 1 else 2
    rows = -(-modes.size // columns)
    fig = new_figure(rows, columns, width=5.2 * columns, row_height=3.8)
    for axes, mode in zip(fig.axes, modes):
        _draw_mode(fig, axes, grid["angular_frequency"].sel(mode=mode).transpose(*names))
        axes.set_title(f"mode {mode}")
    for axes in fig.axes[modes.size : rows * columns]:
        axes.set_visible(False)
    return fig


def _draw_mode(fig: Figure, axes: Axes, values: xr.DataArray) -> None:
    """One map; `values` has the input along y first, the one along x second."""
    y, x = (values[name] for name in values.dims)
    axes.grid(False)
    axes.set_facecolor("0.92")
    masked = np.ma.masked_invalid(values.values)
    if masked.mask.any():
        axes.patch.set(hatch="///", edgecolor="0.6")
        axes.legend(handles=[Patch(facecolor="0.92", edgecolor="0.6", hatch="///", label="no oscillation")])
    if masked.count():
        mesh = axes.pcolormesh(x, y, masked, shading="nearest", cmap="cividis")
        fig.colorbar(mesh, ax=axes, label=axis_label(values))
    for coordinate, set_scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        set_scale("log" if _log_spaced(coordinate.values) else "linear")
    axes.set_xlabel(input_label(x))
    axes.set_ylabel(input_label(y))


def _log_spaced(values: np.ndarray) -> bool:
    """Whether three or more positive values have one ratio from each to the next."""
    if values.size < 3 or values[0] <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.allclose(ratios, ratios[0], rtol=1e-6))
