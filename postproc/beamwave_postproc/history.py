"""Displacement and velocity against time at points of the beam (Figs 6, 7)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .curves import Curve, curves_of, heading
from .events import mark_events
from .labels import axis_label, si_prefix, units_of
from .points import chosen_points
from .result import require, require_numbers
from .style import COLOURS, add_legend, new_figure, sparse_markers, styled

SHARED_INPUTS = ("rotation_angular_velocity", "impact_mass_ratio", "impact_mass", "impact_approach_velocity")
ALONE = {"color": COLOURS[0], "linewidth": 0.8}  # a single history may be dense, and needs no marker


def displacement(ds: xr.Dataset, position: float | None = None) -> Figure:
    """Displacement in the rotating frame against time, one panel per point, or at `position` ξ alone."""
    return _history(ds, "displacement", position)


def velocity(ds: xr.Dataset, position: float | None = None) -> Figure:
    """Velocity in the rotating frame against time, one panel per point, or at `position` ξ alone."""
    return _history(ds, "velocity", position)


@styled
def _history(ds: xr.Dataset, name: str, position: float | None) -> Figure:
    """Draw variable `name` (case, point, time): cases as curves, points as panels that share the time."""
    require(ds, name, "time", "point_position")
    points = chosen_points(ds, position)
    curves = curves_of(ds)
    fig = new_figure(len(points), row_height=4.2 if len(points) == 1 else 2.8)
    for axes, point in zip(fig.axes, points):
        _draw_point(axes, ds, curves, name, point)
    prefix, factor = si_prefix(ds["time"].values, units_of(ds["time"]))
    for axes in fig.axes:
        mark_events(axes, [curve.data for curve in curves], factor, words=axes is fig.axes[0])
    fig.axes[-1].set_xlabel(axis_label(ds["time"], prefix))
    add_legend(fig.axes[0], heading(ds, *SHARED_INPUTS), above=True)
    return fig


def _draw_point(axes: Axes, ds: xr.Dataset, curves: list[Curve], name: str, point: int) -> None:
    """Histories of all `curves` at one point, in the SI prefix that fits them."""
    values = np.array([curve.data[name].isel(point=point).values for curve in curves])
    require_numbers(values, name)
    time = ds["time"].values * si_prefix(ds["time"].values, units_of(ds["time"]))[1]
    prefix, scale = si_prefix(values, units_of(ds[name]))
    for curve, row in zip(curves, values):
        axes.plot(
            time,
            row * scale,
            label=curve.label or None,
            markevery=sparse_markers(curve.index, time.size),
            **(curve.style if len(curves) > 1 else ALONE),
        )
    axes.margins(y=0.1)
    if time.size > 1:
        axes.set_xlim(time[0], 2 * time[-1] - time[-2])
    xi = float(ds["point_position"][point])
    axes.set_ylabel(axis_label(ds[name], prefix, note=rf" at $\xi = {xi:g}$"))
