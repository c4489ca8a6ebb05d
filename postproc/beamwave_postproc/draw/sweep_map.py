"""Mode frequencies over a sweep of two inputs, as maps."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from ..parts.labels import input_label
from ..parts.outcome import varies
from ..parts.select import Chosen, chosen, left_out
from ..parts.sheet import Given, columns_for, sheet_for
from ..parts.spacing import edges_of, space_cells
from ..result import NothingToDraw, require, require_numbers, swept_inputs, to_grid
from ..style import COLOURS, styled

MAX_MODES = 4
SPEED, CRITICAL = "rotation_angular_velocity", "critical_angular_velocity"
GROWS = {"facecolor": "0.92", "edgecolor": "0.6", "hatch": "///", "linewidth": 0.0}
LACKS = "0.75"  # colour of a case without numbers


@styled
def sweep_map(ds: xr.Dataset, *, modes: Chosen = None, ax: Given = None) -> Figure:
    """Map the frequency (Hz) of the lowest modes, or of these `modes`, over the two swept inputs.

    The input that varies fastest runs along x. Where a mode grows the map is hatched, where a case holds no number it
    is grey; where the angular velocity is one of the inputs, the critical speed of the first mode is a line.
    """
    ds = chosen(ds, modes=modes)
    require(ds, "angular_frequency")
    names = swept_inputs(ds)
    if len(names) != 2 or any(np.unique(ds[name]).size < 2 for name in names):
        raise NothingToDraw("the result is not a sweep of two inputs, each of two values or more")
    if np.prod([np.unique(ds[name]).size for name in names]) != ds.sizes["case"]:
        raise NothingToDraw("the cases are no grid of two inputs")
    held = [name for name in ("angular_frequency", "growth_rate") if name in ds]
    grid = to_grid(ds[held].isel(mode=slice(MAX_MODES if modes is None else None)))
    require_numbers(grid["angular_frequency"].values, "angular_frequency")
    grown = (grid["growth_rate"] > 0.0).any() if "growth_rate" in grid else False
    if not grown and not any(varies(mode.values) for mode in grid["angular_frequency"].transpose("mode", ...)):
        raise NothingToDraw("no frequency that differs from case to case")
    numbers = grid["mode"].values
    columns = columns_for(numbers.size)
    rows = -(-numbers.size // columns)
    sheet = sheet_for(ax, rows, columns, width=5.2 * columns, height=3.6)
    for axes, mode in zip(sheet.axes, numbers):
        _draw_mode(axes, grid.sel(mode=mode).transpose(*names))
        axes.set_title(f"Mode {mode}")
        if mode == 1:
            _draw_critical_speed(axes, ds, names)
    for axes in sheet.axes[numbers.size :]:
        axes.set_visible(False)
    return sheet.finish(ds, [left_out(numbers.size, ds["mode"].size, "modes in the file")])


def _draw_mode(axes: Axes, mode: xr.Dataset) -> None:
    """One map; its numbers have the input along y first, the one along x second."""
    frequency = mode["angular_frequency"] / (2.0 * np.pi)
    y, x = (mode[name] for name in frequency.dims)
    axes.grid(visible=False)
    edges = edges_of(x.values), edges_of(y.values)
    masked = np.ma.masked_invalid(frequency.values)
    grows = np.nan_to_num(mode["growth_rate"].values) > 0.0 if "growth_rate" in mode else masked.mask & False
    if grows.any():
        axes.patch.set(**GROWS)
        axes.fill_between([], [], label="grows", **GROWS)
    lacks = masked.mask & ~grows
    if lacks.any():
        axes.pcolormesh(*edges, np.ma.masked_array(lacks, ~lacks), cmap=ListedColormap([LACKS]))
        axes.fill_between([], [], label="no numbers", color=LACKS)
    if masked.count():
        mesh = axes.pcolormesh(*edges, masked, cmap="cividis", rasterized=True)
        axes.figure.colorbar(mesh, ax=axes, label="Frequency (Hz)")
    for coordinate, which in ((x, "x"), (y, "y")):
        axes.set(**{f"{which}label": input_label(coordinate)})
        space_cells(axes, which, coordinate.values)


def _draw_critical_speed(axes: Axes, ds: xr.Dataset, names: list[str]) -> None:
    """The line along which the angular velocity is the critical one of each value of the other input."""
    if SPEED not in names or CRITICAL not in ds:
        return
    (other,) = (name for name in names if name != SPEED)
    critical = to_grid(ds[[CRITICAL]])[CRITICAL].isel({SPEED: 0})  # the same at every angular velocity
    speed = np.where(critical <= ds[SPEED].max(), critical, np.nan)
    if not np.isfinite(speed).any():
        return
    line = (speed, critical[other]) if names[1] == SPEED else (critical[other], speed)
    limits = axes.get_xlim(), axes.get_ylim()
    axes.plot(*line, color=COLOURS[2], linewidth=2.0, label="critical speed")
    axes.set(xlim=limits[0], ylim=limits[1])
