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
SPEED, CRITICAL = "rotation_angular_velocity", "critical_angular_velocity"


@styled
def sweep_map(ds: xr.Dataset) -> Figure:
    """Map `angular_frequency` (case, mode) of the lowest modes over the two swept inputs.

    The input that varies fastest runs along x. Where a mode does not oscillate the map is hatched; where the angular
    velocity is one of the inputs, the speed at which the first mode comes to a halt is a line.
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
    _draw_critical_speed(fig.axes[0], ds, names)
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
        none = Patch(facecolor="0.92", edgecolor="0.6", hatch="///", label="no oscillation")
        axes.legend(handles=[none], loc="upper right")
    if masked.count():
        mesh = axes.pcolormesh(x, y, masked, shading="nearest", cmap="cividis")
        fig.colorbar(mesh, ax=axes, label=axis_label(values))
    for coordinate, set_scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        set_scale("log" if _log_spaced(coordinate.values) else "linear")
    axes.set_xlabel(input_label(x))
    axes.set_ylabel(input_label(y))


def _draw_critical_speed(axes: Axes, ds: xr.Dataset, names: list[str]) -> None:
    """The line along which the angular velocity is the critical one of each value of the other input."""
    if SPEED not in names or CRITICAL not in ds:
        return
    (other,) = (name for name in names if name != SPEED)
    critical = to_grid(ds[[CRITICAL]])[CRITICAL].isel({SPEED: 0})  # the same at every angular velocity
    speed = np.where(critical <= ds[SPEED].max(), critical, np.nan)
    if not np.isfinite(speed).any():
        return
    along_x = names[1] == SPEED
    line = (speed, critical[other]) if along_x else (critical[other], speed)
    limits = axes.get_xlim(), axes.get_ylim()
    axes.plot(*line, color="crimson", linewidth=2.0, label="critical speed")
    axes.set(xlim=limits[0], ylim=limits[1])
    shown = axes.get_legend()
    handles = [*(shown.legend_handles if shown else []), axes.lines[-1]]
    axes.legend(handles=handles, loc="upper right")


def _log_spaced(values: np.ndarray) -> bool:
    """Whether three or more positive values have one ratio from each to the next."""
    if values.size < 3 or values[0] <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.allclose(ratios, ratios[0], rtol=1e-6))
