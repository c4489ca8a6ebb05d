"""Displacement, velocity and bending moment against time at points of the beam (Figs 6, 7)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.curves import Curve, Panel, panels_of
from ..parts.envelope import draw_envelope, is_dense
from ..parts.events import ROW, mark_events
from ..parts.growth import grows, growth_note, samples_held, scale_for_growth
from ..parts.labels import axis_label
from ..parts.points import FEW, MAX_POINTS, error_note, point_label, sheet_of_points, shown_points, thinned
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given
from ..parts.units import si_prefix, units_of
from ..result import NothingToDraw, require
from ..stress import factors
from ..style import COLOURS, say_zero, sparse_markers, styled

ALONE = {"color": COLOURS[1], "linewidth": 1.0}  # a single history may be dense, and needs no marker
COLUMNS = 3  # panels of cases beside each other
ALIKE = 5.0  # times the smallest peak, up to which panels of one row have one scale


def displacement(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Displacement in the rotating frame against time, a row of panels for each point, or for those at `points` (ξ)."""
    return _history(chosen(ds, points=points, cases=cases), "displacement", ax, MAX_POINTS if points is None else None)


def velocity(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Velocity in the rotating frame against time, a row of panels for each point, or for those at `points` (ξ)."""
    return _history(chosen(ds, points=points, cases=cases), "velocity", ax, MAX_POINTS if points is None else None)


def bending_moment(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Bending moment against time, a row of panels for each point, or for those at `points` (ξ)."""
    return _history(
        chosen(ds, points=points, cases=cases), "bending_moment", ax, MAX_POINTS if points is None else None
    )


@styled
def _history(ds: xr.Dataset, name: str, ax: Given, limit: int | None) -> Figure:
    """Draw variable `name` (case, point, time): points as rows, panels of cases as columns, all against one time."""
    require(ds, name, "time", "point_position")
    drawn = panels_of(ds, name, panels=COLUMNS)
    points = shown_points(ds, limit or ds.sizes["point"])
    if limit and len(drawn.panels) > 1:
        points = shown_points(ds, FEW)
    sheet = sheet_of_points(ax, len(points), len(drawn.panels))
    notes = [
        note for row, point in zip(sheet.grid, points) for note in _draw_row(list(row), ds, drawn.panels, name, point)
    ]
    for column, panel in zip(sheet.grid.T, drawn.panels):
        _mark_time(list(column), ds, panel, name)
    cases = [curve.data for curve in drawn.curves]
    told = (*drawn.notes, thinned(ds, points), growth_note(cases, name), error_note(ds, cases, name, points), *notes)
    return sheet.finish(ds, dict.fromkeys(told))


def _draw_row(row: list[Axes], ds: xr.Dataset, panels: list[Panel], name: str, point: int) -> list[str]:
    """Histories of all cases at one point, in the SI prefix that fits the smallest; what has to be said of them."""
    values = [np.array([curve.data[name][point].values for curve in panel.curves]) for panel in panels]
    growing = [[grows(curve.data) for curve in panel.curves] for panel in panels]
    least = min(filter(None, _peaks(values)), default=0.0)
    prefix, scale = si_prefix(np.array([least]), units_of(ds[name]))
    several = sum(len(panel.curves) for panel in panels) > 1
    notes = []
    for axes, panel, rows, flags in zip(row, panels, values, growing):
        axes.set_autoscaley_on(not any(flags))  # matplotlib's margin would overflow
        notes += [_draw_history(axes, ds, curve, scale * line, several) for curve, line in zip(panel.curves, rows)]
    _scale_row(row, [scale * rows for rows in values], growing)
    row[0].set_ylabel(point_label(ds, name, point, prefix))
    if name == "bending_moment":
        _add_stress(row[-1], [curve for panel in panels for curve in panel.curves], point, scale)
    return notes


def _add_stress(axes: Axes, curves: list[Curve], point: int, scale: float) -> None:
    """At the right the stress of the outermost fibre, where the section tells it and all cases share it."""
    try:
        found = {float(factors(curve.data, "stress")[point]) for curve in curves}
    except (KeyError, NothingToDraw):
        return
    if len(found) > 1:
        return
    (of_moment,) = found
    prefix, times = si_prefix(
        np.array([curve.data["bending_moment"][point].values for curve in curves]) * of_moment, "Pa"
    )
    factor = of_moment * times / scale
    stress = axes.secondary_yaxis("right", functions=(lambda moment: moment * factor, lambda stress: stress / factor))
    stress.set_ylabel(f"Stress of the outermost\nfibre ({prefix}Pa)")


def _draw_history(axes: Axes, ds: xr.Dataset, curve: Curve, values: np.ndarray, several: bool) -> str:
    """One history as a line, or where a line would fill the picture as a band; what is drawn then."""
    time = ds["time"].values * _time_factor(ds)
    style = {**curve.style, "markevery": sparse_markers(curve.index, time.size)} if several else ALONE
    style = {**style, "marker": "o"} if time.size == 1 else style
    if is_dense(values):
        axes.plot([], [], label=curve.label or None, color=style["color"])
        return draw_envelope(axes, time, values, colour=style["color"])
    axes.plot(time, values, label=curve.label or None, **style)
    return ""


def _scale_row(row: list[Axes], values: list[np.ndarray], growing: list[list[bool]]) -> None:
    """One scale for the panels of a row, each with its `values` (curve, time), where that suits all; else one each."""
    peaks = _peaks(values)
    if max(peaks) / ALIKE > min(peaks):
        for axes, panel, flags in zip(row, values, growing):
            _scale_values(axes, panel, flags)
        return
    for axes in row:
        _scale_values(axes, np.concatenate(values), [flag for flags in growing for flag in flags])
    limits = np.array([axes.get_ylim() for axes in row])
    for axes in row:
        axes.set_ylim(limits[:, 0].min(), limits[:, 1].max())
    for axes in row[1:]:
        axes.tick_params(labelleft=False)


def _peaks(values: list[np.ndarray]) -> list[float]:
    """Largest magnitude in each panel."""
    return [float(np.nanmax(np.abs(panel), initial=0.0)) for panel in values]


def _scale_values(axes: Axes, values: np.ndarray, growing: list[bool]) -> None:
    """Choose the y axis for what is drawn: it may grow without bound, or be at rest; else it is matplotlib's."""
    axes.margins(y=0.08)
    if not np.nan_to_num(values).any():
        say_zero(axes)
    elif any(growing):
        scale_for_growth(axes, values, growing)


def _mark_time(column: list[Axes], ds: xr.Dataset, panel: Panel, name: str) -> None:
    """Time axis of one column up to its last number, its events, and what its cases share."""
    factor, cases = _time_factor(ds), [curve.data for curve in panel.curves]
    held = max(samples_held(case, name) for case in cases)
    time = ds["time"].values[:held] * factor
    for axes in column:
        end = 2 * time[-1] - time[-2] if time.size > 1 else float(ds.get("response_duration", 1.0)) * factor
        axes.set_xlim(time[0], end)
        rows = mark_events(axes, cases, factor, words=axes is column[0])
        if axes is column[0]:
            axes.set_title(panel.title, pad=6.0 + ROW * rows)
    column[-1].set_xlabel(axis_label(ds["time"], si_prefix(ds["time"].values, units_of(ds["time"]))[0]))


def _time_factor(ds: xr.Dataset) -> float:
    """Factor from seconds to the unit of the time axis."""
    return si_prefix(ds["time"].values, units_of(ds["time"]))[1]
