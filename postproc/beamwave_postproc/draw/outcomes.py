"""What the cases of a sweep of one input came to, over that input."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.labels import in_units, quantity
from ..parts.outcome import OUTCOMES, SPEED, as_frequency, input_axis, varied_inputs, varies
from ..parts.select import left_out, spread
from ..parts.sheet import Given, columns_for, sheet_for
from ..parts.units import drawable, number_text, si_prefix, units_of
from ..result import NothingToDraw
from ..style import curve_style, logarithmic, styled

FEWEST = 3  # cases
FEW_CASES = 40  # up to which each is marked
MODES = 3
POINTS = 4  # of numbers along the beam
FREQUENCY = "angular_frequency"
NUMBERS = (*OUTCOMES, "impulse")
MANY = 1e3  # between the least and the largest number of an axis, from where on it is logarithmic


class Panel(NamedTuple):
    """What one pair of axes shows: a curve for each row of `curves` (curve, case), and the number of its look."""

    variable: xr.DataArray
    words: str
    curves: np.ndarray
    looks: list[int]


@styled
def outcomes(ds: xr.Dataset, *, only: Sequence[str] | None = None, ax: Given = None) -> Figure:
    """Draw the frequencies of the lowest modes, largest displacement, stress and contact force, restitution, last velocity of the mass and impulse
    over the one input that a sweep or a design varies, as far as they differ from case to case.

    Numbers along the beam have a curve for each point, at most four. Frequencies over the angular velocity are left to
    `campbell`. With `only`, names of variables as `largest_stress`, the others are left out. Raises `NothingToDraw` unless three
    cases vary one input.
    """
    names = varied_inputs(ds) if "case" in ds.dims else []
    if len(names) != 1 or ds.sizes["case"] < FEWEST:
        raise NothingToDraw("needs three cases or more that vary one input alone")
    ds = ds.isel(case=np.argsort(ds[names[0]].values, kind="stable"))
    drawn = [name for name in NUMBERS if name in ds and (only is None or name in only)]
    ds = ds.assign({name: drawable(ds[name]) for name in drawn})
    moving = sorted({point for name in drawn if "point" in ds[name].dims for point in _moving(ds[name])})
    points = [moving[i] for i in spread(len(moving), POINTS)]
    modes = names[0] != SPEED and (only is None or FREQUENCY in only)
    panels = [*(_frequencies(ds) if modes else []), *_numbers(ds, drawn, points)]
    if not panels:
        raise NothingToDraw("no frequency, largest value, restitution or impulse that differs from case to case")
    columns = columns_for(len(panels))
    sheet = sheet_for(ax, -(-len(panels) // columns), columns, width=6.4 if columns == 1 else 9.6, height=2.8)
    for look, point in enumerate(points):
        place = rf"$\xi$ = {number_text(ds['point_position'].values[point])}"
        sheet.axes[0].plot([], [], label=place, **curve_style(look))
    for axes, panel in zip(sheet.axes, panels):
        _draw(axes, ds[names[0]], panel)
    for axes in sheet.axes[len(panels) :]:
        axes.set_visible(False)
    lacking = max(int(np.isnan(panel.curves).sum(axis=1).max()) for panel in panels)
    notes = [
        f"{ds.sizes['case']} cases",
        f"up to {lacking} without numbers" if lacking else "",
        left_out(len(points), len(moving), "points that move"),
    ]
    return sheet.finish(ds, notes)


def _frequencies(ds: xr.Dataset) -> list[Panel]:
    """Frequencies of the lowest modes, each on axes of its own."""
    if FREQUENCY not in ds or ds[FREQUENCY].dims != ("case", "mode"):
        return []
    hertz = as_frequency(ds[FREQUENCY]).isel(mode=slice(MODES))
    rows = zip(hertz["mode"].values, hertz.values.T)
    return [Panel(hertz, f"Frequency of mode {number}", row[None], [0]) for number, row in rows if varies(row)]


def _numbers(ds: xr.Dataset, names: list[str], points: list[int]) -> list[Panel]:
    """These numbers of each case, those along the beam at these points, each with a look of its own."""
    found = []
    for name in names:
        values, along = ds[name].values.T, "point" in ds[name].dims
        shown = [point for point in _moving(ds[name]) if point in points or not along]
        if shown:
            looks = [points.index(i) if along else 0 for i in shown]
            found.append(Panel(ds[name], quantity(ds[name]), np.atleast_2d(values)[shown], looks))
    return found


def _moving(variable: xr.DataArray) -> list[int]:
    """Indices of the points at which a number of each case varies; 0 of one without points that does."""
    if variable.dims not in {("case",), ("case", "point")}:
        return []
    return [i for i, row in enumerate(np.atleast_2d(variable.values.T)) if varies(row)]


def _draw(axes: Axes, given: xr.DataArray, panel: Panel) -> None:
    """The curves of one panel, from zero on where that leaves them half of the axes, by decades where they span many."""
    x = input_axis(axes, "x", given)
    prefix, factor = si_prefix(panel.curves, units_of(panel.variable))
    for row, look in zip(panel.curves, panel.looks):
        axes.plot(x, factor * row, **curve_style(look) | ({} if x.size <= FEW_CASES else {"marker": ""}))
    axes.set_ylabel(panel.words + in_units(panel.variable, prefix))
    low, high = factor * np.nanmin(panel.curves), factor * np.nanmax(panel.curves)
    if 0.0 < low < high / MANY:
        logarithmic(axes, "y", low / 2.0, 2.0 * high)
    elif 0.0 <= low < 0.5 * high:
        axes.set_ylim(bottom=0.0)
