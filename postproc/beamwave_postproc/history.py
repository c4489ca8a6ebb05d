"""Displacement and velocity against time at points of the beam (Figs 6, 7)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .curves import Curve, curves_of, heading
from .events import leave_room, mark_events
from .growth import grows, samples_held, scale_for_growth
from .labels import axis_label, rough, si_prefix, units_of
from .legend import add_legend
from .points import chosen_points, panels_for, point_label, thinned
from .result import require, require_numbers
from .style import COLOURS, sparse_markers, styled

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
    fig = panels_for(points)
    rows = [_draw_point(axes, ds, curves, name, point) for axes, point in zip(fig.axes, points)]
    prefix, factor = si_prefix(ds["time"].values, units_of(ds["time"]))
    held = max(samples_held(curve.data, name) for curve in curves)
    _limit_time(fig.axes[-1], ds["time"].values[:held] * factor)
    for axes, values in zip(fig.axes, rows):
        _scale_values(axes, values, [grows(curve.data) for curve in curves])
        leave_room(axes, mark_events(axes, [curve.data for curve in curves], factor, words=axes is fig.axes[0]))
    fig.axes[-1].set_xlabel(axis_label(ds["time"], prefix))
    notes = (heading(ds, *SHARED_INPUTS), thinned(ds, points), _growth_note(curves, name), _error(curves, name, points))
    add_legend(fig.axes[0], "; ".join(filter(None, notes)), above=True)
    return fig


def _draw_point(axes: Axes, ds: xr.Dataset, curves: list[Curve], name: str, point: int) -> np.ndarray:
    """Histories of all `curves` at one point, in the SI prefix that fits them: drawn, and returned (curve, time)."""
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
    axes.set_autoscaley_on(not any(grows(curve.data) for curve in curves))  # matplotlib's margin would overflow
    axes.set_ylabel(point_label(ds, name, point, prefix))
    return values * scale


def _scale_values(axes: Axes, values: np.ndarray, growing: list[bool]) -> None:
    """Choose the y axis for what is drawn: it may grow without bound, or be at rest; else it is matplotlib's."""
    if not np.nan_to_num(values).any():
        _say_zero(axes)
    elif any(growing):
        scale_for_growth(axes, values, growing)


def _say_zero(axes: Axes) -> None:
    """Put 0 alone on the axis of a point at rest: any other number would be invented."""
    axes.set(ylim=(-1.0, 1.0), yticks=[0.0])
    axes.annotate("zero", (0.5, 0.5), xycoords="axes fraction", xytext=(0, 3), textcoords="offset points", ha="center")


def _limit_time(axes: Axes, time: np.ndarray) -> None:
    """Time axis from the first sample to one step after the last that holds a number."""
    if time.size > 1:
        axes.set_xlim(time[0], 2 * time[-1] - time[-2])


def _growth_note(curves: list[Curve], name: str) -> str:
    """What a history that grows does to the picture; empty where none does."""
    growing = [curve.data for curve in curves if grows(curve.data)]
    if not growing:
        return ""
    short = [case for case in growing if samples_held(case, name) < case.sizes["time"]]
    words = "unstable: symmetric logarithmic scale"
    if not short:
        return words
    first = min(samples_held(case, name) for case in short)
    return f"{words}; numbers overflow after {float(short[0]['time'][max(first - 1, 0)]):.3g} s"


def _error(curves: list[Curve], name: str, points: list[int]) -> str:
    """Largest of the estimates of error at the points drawn, each over the peak there; empty without estimates."""
    largest = 0.0
    for curve in curves:
        if f"{name}_error" not in curve.data:
            return ""
        peak = np.abs(curve.data[name].isel(point=points)).max("time").values
        error = curve.data[f"{name}_error"].isel(point=points).values
        known = np.isfinite(error) & (peak > 0.0)
        largest = max(largest, np.max(error[known] / peak[known], initial=0.0))
    return f"error ≈ {rough(largest)} of the peak" if largest > 0.0 else ""
