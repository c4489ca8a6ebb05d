"""Mode shapes along the beam: of one case one above the other, of several beside each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.curves import Curve, panels_of, where_it_varies
from ..parts.labels import axis_label
from ..parts.places import mark_places
from ..parts.select import Chosen, chosen, left_out
from ..parts.sheet import Given, Sheet, columns_for, sheet_for
from ..parts.units import with_unit
from ..result import require
from ..style import ABOVE_GRID, GREY, styled

MAX_MODES = 6
HALF = 0.42  # of the distance between two modes that the largest deflection takes
ONE_LINE = 0.02  # of the largest deflection, within which shapes are drawn as one
ROUNDING = 1e-9  # of the largest of all shapes: a shape below it is zero
FIRST = 0.1  # of the largest deflection: where a beam is deflected, seen from the root
SAMPLES_PER_WAVE = 6  # of a mode, that a line through the samples shows its form


@styled
def mode_shapes(ds: xr.Dataset, *, modes: Chosen = None, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `mode_shape` (case, mode, profile) of the lowest modes, or of these `modes`.

    Of one case each is on its own zero line, with its frequency beside it, or that it grows; cases of a sweep share axes of their
    mode. Every shape has one largest deflection, and deflects upwards first, from the root on. Cases of a mode that are one line as
    drawn are drawn as one. A shape with too few samples for its waves is drawn as samples alone, with a note.
    """
    ds = chosen(ds, modes=modes, cases=cases)
    require(ds, "mode_shape", "profile_position")
    there = ds.sizes["mode"]
    ds = ds.isel(mode=slice(MAX_MODES if modes is None else None))
    varying, same = where_it_varies(ds, "mode_shape")
    drawn = panels_of(varying, "mode_shape", panels=1)
    count, position = ds.sizes["mode"], ds["profile_position"].values
    coarse = [int(number) for number in ds["mode"].values if number / 2.0 * SAMPLES_PER_WAVE > position.size - 1]
    named = not same or ("angular_frequency" in ds and where_it_varies(ds, "mode_shape", "angular_frequency")[1] == same)
    draw = _draw_one if len(drawn.curves) == 1 else _draw_several
    sheet = draw(ax, ds, drawn.curves, coarse, named=named)
    few = f"{position.size} samples do not show modes {', '.join(map(str, coarse))}" if coarse else ""
    return sheet.finish(ds, [*drawn.notes, same, left_out(count, there, "modes in the file"), few])


def _draw_one(ax: Given, ds: xr.Dataset, curves: list[Curve], coarse: list[int], *, named: bool) -> Sheet:
    """The modes of one case above each other; `named` where its frequencies are those of all."""
    count, position = ds.sizes["mode"], ds["profile_position"].values
    sheet = sheet_for(ax, height=max(0.75 * count, 1.5) + 0.7)
    axes, (curve,) = sheet.axes[0], curves
    for row, number in enumerate(ds["mode"].values):
        axes.plot(position, row + HALF * _unit_shape(curve.data, row), **_look(curve, number in coarse))
        axes.axhline(row, color=GREY, linewidth=0.6, zorder=ABOVE_GRID)
    words = [_frequency(curve.data, row) if named else "" for row in range(count)]
    words = [word if _unit_shape(curve.data, row).any() else "\nturn of the whole" for row, word in enumerate(words)]
    axes.set_yticks(range(count), [f"mode {number}{word}" for number, word in zip(ds["mode"].values, words)])
    mark_places(axes, ds, "x", first=True)
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set(xlim=(position.min(), position.max()), ylim=(-0.6, count - 0.4), xlabel=axis_label(ds["profile_position"]))
    return sheet


def _draw_several(ax: Given, ds: xr.Dataset, curves: list[Curve], coarse: list[int], *, named: bool) -> Sheet:
    """The modes of several cases, each on axes of its own."""
    count, position = ds.sizes["mode"], ds["profile_position"].values
    columns = columns_for(count)
    rows = -(-count // columns)
    sheet = sheet_for(ax, rows, columns, width=4.6 * columns, height=1.9 if rows > 1 else 2.8, share="x")
    for row, (axes, number) in enumerate(zip(sheet.axes, ds["mode"].values)):
        shapes = [_unit_shape(curve.data, row) for curve in curves]
        alike = all(np.allclose(shape, shapes[0], rtol=0.0, atol=ONE_LINE) for shape in shapes)
        for curve, shape in list(zip(curves, shapes))[: 1 if alike else None]:
            axes.plot(position, shape, **_look(curve, number in coarse))
        words = " and ".join(dict.fromkeys(_frequency(curves[i].data, row).strip() for i in (0, -1)))
        axes.set_title(f"mode {number}" + (f", {words.replace(' and ', ' … ')}" if words and named else "") + (": all alike" if alike else ""))
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=ABOVE_GRID)
        mark_places(axes, ds, "x", first=True)
        axes.set(xlim=(position.min(), position.max()), ylim=(-1.15, 1.15), yticks=[-1.0, 0.0, 1.0])
    for axes in sheet.axes[count:]:
        axes.set_visible(False)
    for axes in sheet.axes[max(0, count - columns) : count]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(axis_label(ds["profile_position"]))
    for curve in curves:  # also those that are drawn as one with the first
        sheet.axes[0].plot([], [], label=curve.label or None, **_look(curve, coarse=False))
    return sheet


def _unit_shape(case: xr.Dataset, row: int) -> np.ndarray:
    """A shape over its largest deflection, first deflected upwards as seen from the root."""
    shapes = case["mode_shape"].values
    largest = np.nanmax(np.abs(shapes[row]), initial=0.0)
    if largest <= ROUNDING * np.nanmax(np.abs(shapes), initial=0.0):
        return 0.0 * shapes[row]  # as of a turn of the whole, seen from the turning hub
    shape = shapes[row] / largest
    deflected = np.flatnonzero(np.abs(shape) > FIRST)
    return shape if not deflected.size or shape[deflected[0]] > 0.0 else -shape


def _look(curve: Curve, coarse: bool) -> dict[str, Any]:
    """Look of a case: its samples alone where they are too coarse."""
    return {**curve.style, "marker": ".", "linestyle": ""} if coarse else {**curve.style, "marker": ""}


def _frequency(case: xr.Dataset, row: int) -> str:
    """Second line of a mode's name: its frequency, or that it grows."""
    if "angular_frequency" not in case:
        return ""
    beta = float(case["angular_frequency"][row])
    if np.isfinite(beta):
        return f"\n{with_unit(beta / (2.0 * np.pi), 'Hz')}"
    return "\ngrows" if float(case.get("growth_rate", xr.zeros_like(case["angular_frequency"]))[row]) > 0.0 else ""
