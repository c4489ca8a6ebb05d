"""Displacement, velocity and bending moment against time at points of the beam (Figs 6, 7), and the turn of its hub."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.bands import draw_bands, is_scattered
from ..parts.curves import Curve, Panel, panels_of
from ..parts.envelope import draw_envelope, is_dense
from ..parts.events import ROW, lanes_note, mark_events
from ..parts.growth import end_note, grows, growth_note, samples_held, scale_for_growth
from ..parts.labels import axis_label
from ..parts.passage import acted_part
from ..parts.points import (
    FEW,
    MAX_POINTS,
    common_prefixes,
    error_note,
    error_warning,
    point_label,
    rests,
    sheet_of_points,
    shown_points,
)
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, columns_for
from ..parts.units import LARGEST, si_prefix, units_of, with_unit
from ..result import NothingToDraw, require
from ..stress import factors
from ..style import COLOURS, say_zero, sparse_markers, styled

ALONE = {"color": COLOURS[1], "linewidth": 1.0}  # a single history may be dense, and needs no marker
COLUMNS = 3  # panels of cases beside each other
# How the variables begin that are asked for of each of many cases, beside the histories: a dataset of all would be slow.
OF_CASES = ("time", "point_position", "growth_rate", "event_", "case", "beam_")
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


def acceleration(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Acceleration in the rotating frame against time, a row of panels for each point, or for those at `points` (ξ)."""
    return _history(chosen(ds, points=points, cases=cases), "acceleration", ax, MAX_POINTS if points is None else None)


def shear_force(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Shear force against time, a row of panels for each point, or for those at `points` (ξ)."""
    return _history(chosen(ds, points=points, cases=cases), "shear_force", ax, MAX_POINTS if points is None else None)


def hub_angle(ds: xr.Dataset, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Turn of a hub that is free, beyond the even rotation, against time."""
    ds = chosen(ds, cases=cases)
    require(ds, "hub_angle", "time")
    alone = ds.drop_dims("point", errors="ignore")  # as a history at one place, which is none of the beam's
    turn = alone["hub_angle"].expand_dims("point").transpose(..., "point", "time")
    return _history(alone.assign(hub_angle=turn, point_position=("point", [np.nan])), "hub_angle", ax, None)


@styled
def _history(ds: xr.Dataset, name: str, ax: Given, limit: int | None) -> Figure:
    """Draw variable `name` (case, point, time): points as rows, panels of cases as columns, all against one time.

    Beside a single panel stands what is too short to be seen in it: the part of the record in which a force acts.
    """
    require(ds, name, "time", "point_position")
    if is_scattered(ds):
        return _of_many(ds, name, ax, limit)
    drawn = panels_of(ds, name, panels=COLUMNS)
    cases = [curve.data for curve in drawn.curves]
    points, left = shown_points(ds, cases, name, FEW if limit and len(drawn.panels) > 1 else limit)
    near = acted_part(cases) if ax is None and len(drawn.panels) == 1 and columns_for(2) == 2 else None
    panels = drawn.panels if near is None else [*drawn.panels, _part_of(drawn.panels[0], near)]
    sheet = sheet_of_points(ax, len(points), len(panels))
    scales = common_prefixes([_least(drawn.panels, name, point) for point in points], units_of(ds[name]))
    notes = []
    for row, point, (prefix, scale) in zip(sheet.grid, points, scales):
        notes += _draw_row(list(row), panels, name, point, scale, several=len(drawn.curves) > 1)
        row[0].set_ylabel(point_label(ds, name, point, prefix))
    if name == "bending_moment":
        _add_stress([row[-1] for row in sheet.grid], cases, points, [scale for _, scale in scales])
    for column, panel in zip(sheet.grid.T, panels):
        _mark_time(list(column), panel, name)
    ends = (growth_note(cases, name), end_note(cases, name))
    lanes = [lanes_note([curve.data for curve in panel.curves]) for panel in drawn.panels]
    notes += [_what_part(near)] if near else []
    told = (*drawn.notes, left, *ends, error_note(ds, cases, name, points), *notes, *lanes)
    return sheet.finish(ds, dict.fromkeys(told), warning=error_warning(cases, name, points))


def _of_many(ds: xr.Dataset, name: str, ax: Given, limit: int | None) -> Figure:
    """Draw the bands in which variable `name` of all cases lies, points as rows, and what is the same for all."""
    slim = ds.drop_vars([other for other in ds.variables if not str(other).startswith((name, *OF_CASES))]).load()
    cases = [slim.isel(case=i) for i in range(ds.sizes["case"])]
    cases = [case for case in cases if np.isfinite(case[name].values).any()]
    if not cases:
        raise NothingToDraw(f"{name} holds nothing but fill")
    points, left = shown_points(ds, cases, name, limit)
    sheet = sheet_of_points(ax, len(points), 1)
    values = [np.array([case[name].values[point] for case in cases]) for point in points]
    scales = common_prefixes(_peaks(values), units_of(ds[name]))
    growing = [grows(case) for case in cases]
    for axes, point, rows, (prefix, scale) in zip(sheet.axes, points, values, scales):
        draw_bands(axes, ds["time"].values * _time_factor(ds), scale * rows)
        axes.set_ylabel(point_label(ds, name, point, prefix))
        _scale_values(axes, scale * rows, growing)
    if name == "bending_moment":
        _add_stress(sheet.axes, cases, points, [scale for _, scale in scales])
    _mark_time(sheet.axes, Panel("", [Curve(0, case, "", {}) for case in cases]), name, alike=True)
    lost = ds.sizes["case"] - len(cases)
    told = [f"{len(cases)} cases" + (f", {lost} more without numbers" if lost else ""), left, growth_note(cases, name)]
    told += [end_note(cases, name), error_note(ds, cases, name, points)]
    return sheet.finish(ds, told, warning=error_warning(cases, name, points))


def _least(panels: list[Panel], name: str, point: int) -> float:
    """The smallest of the panels' peaks at one point, but for those that rest: what a unit of the row has to fit."""
    return min(filter(None, _peaks([_rows(panel, name, point) for panel in panels])), default=0.0)


def _rows(panel: Panel, name: str, point: int) -> np.ndarray:
    """Histories (curve, time) of a panel at one point."""
    return np.array([curve.data[name].values[point] for curve in panel.curves])


def _part_of(panel: Panel, part: tuple[float, float]) -> Panel:
    """The same curves between two times (s)."""
    time = panel.curves[0].data["time"].values
    samples = slice(*(int(np.searchsorted(time, end)) for end in part))
    return Panel("", [replace(curve, data=curve.data.isel(time=samples)) for curve in panel.curves])


def _what_part(part: tuple[float, float]) -> str:
    """Which part of the record stands at the right, in words."""
    begin, length = part[0], with_unit(part[1] - part[0], "s", 2)
    return f"right, enlarged: the {length} from {with_unit(begin, 's', 3)} on" if begin > 0.0 else f"right, enlarged: the first {length}"


def _draw_row(row: list[Axes], panels: list[Panel], name: str, point: int, scale: float, *, several: bool) -> list[str]:
    """Histories of all cases at one point, times `scale`, which differ in their looks where there are several; what has to be said of them."""
    values = [_rows(panel, name, point) for panel in panels]
    growing = [[grows(curve.data) for curve in panel.curves] for panel in panels]
    notes = []
    for axes, panel, rows, flags in zip(row, panels, values, growing):
        axes.set_autoscaley_on(not any(flags))  # matplotlib's margin would overflow
        notes += [_draw_history(axes, curve, scale * line, several) for curve, line in zip(panel.curves, rows)]
    _scale_row(row, [scale * rows for rows in values], growing)
    return notes


def _add_stress(column: list[Axes], cases: list[xr.Dataset], points: list[int], scales: list[float]) -> None:
    """At the right the stress of the outermost fibre, where the section tells it and all cases share it.

    `column` are the axes of moments at `points`, drawn times `scales`.
    """
    try:
        of_cases = np.array([factors(case, "stress")[points] for case in cases])
    except (KeyError, NothingToDraw):
        return
    of_moment = of_cases[0]
    if (of_cases != of_moment).any():
        return
    peaks = [max(_peaks([case["bending_moment"].values[point] for case in cases])) for point in points]
    for axes, own, peak, scale, (prefix, times) in zip(
        column, of_moment, peaks, scales, common_prefixes(list(of_moment * peaks), "Pa")
    ):
        highest = np.abs(axes.get_ylim()).max()
        if peak > 0.0 and np.log10([own, times / scale, highest]).sum() < np.log10(LARGEST):
            _add_axis(axes, own * times / scale, f"Outermost fibre's\nstress ({prefix}Pa)")


def _add_axis(axes: Axes, factor: float, label: str) -> None:
    """A second y axis at the right, of what is `factor` times the first."""
    right = axes.secondary_yaxis("right", functions=(lambda value: value * factor, lambda value: value / factor))
    right.set_ylabel(label)


def _draw_history(axes: Axes, curve: Curve, values: np.ndarray, several: bool) -> str:
    """One history as a line, or where a line would fill the picture as a band; what is drawn then."""
    time = curve.data["time"].values * _time_factor(curve.data)
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
    whole = [panel for panel in values if panel.shape[1] == values[0].shape[1]]  # without a part seen from near
    for axes in row:
        _scale_values(axes, np.concatenate(whole), [flag for flags in growing[: len(whole)] for flag in flags])
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
    if rests(values):
        say_zero(axes)
    elif any(growing):
        scale_for_growth(axes, values, growing)


def _mark_time(column: list[Axes], panel: Panel, name: str, *, alike: bool = False) -> None:
    """Time axis of one column up to its last number, its events, of which with `alike` those that all cases share, and its title."""
    cases = [curve.data for curve in panel.curves]
    ds = cases[0]
    factor = _time_factor(ds)
    colours = [] if alike else [curve.style["color"] for curve in panel.curves]
    held = max(samples_held(case, name) for case in cases)
    time = ds["time"].values[:held] * factor
    for axes in column:
        end = 2 * time[-1] - time[-2] if time.size > 1 else float(ds.get("response_duration", 1.0)) * factor
        axes.set_xlim(time[0], end)
        rows = mark_events(axes, cases, factor, words=axes is column[0], alike=alike, colours=colours)
        if axes is column[0]:
            axes.set_title(panel.title, pad=6.0 + ROW * rows)
    column[-1].set_xlabel(axis_label(ds["time"], si_prefix(ds["time"].values, units_of(ds["time"]))[0]))


def _time_factor(ds: xr.Dataset) -> float:
    """Factor from seconds to the unit of the time axis."""
    return si_prefix(ds["time"].values, units_of(ds["time"]))[1]
