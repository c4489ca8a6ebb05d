"""The moving beam at a glance: its deflection, or its bending moment, over place and time, as an image."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.envelope import largest_of_each
from ..parts.events import ROW, mark_events
from ..parts.growth import end_note, grows, samples_held
from ..parts.labels import axis_label
from ..parts.line import FORCES, Line, beam_line, force_line, places_of_line, whole_line
from ..parts.passage import first_part
from ..parts.places import mark_places
from ..parts.points import error_warning
from ..parts.select import Chosen, chosen, one_case
from ..parts.sheet import Given, columns_for, sheet_for
from ..parts.units import si_prefix, units_of
from ..result import NothingToDraw, require, require_numbers
from ..stress import factors
from ..style import styled

PLACES, TIMES = 160, 450  # of the image, no more than it has dots on paper, so that each is seen
BLOCK = 2**16  # samples whose lines are drawn at once, for the memory
ALIKE = 1e-9  # of a stress: rounding


def space_time_moment(ds: xr.Dataset, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw the bending moment of the first case over time (x) and place ξ (y), with the stress that goes with it where one section tells it."""
    return space_time(ds, "bending_moment", cases=cases, ax=ax)


@styled
def space_time(ds: xr.Dataset, name: str = "displacement", *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `displacement` (or another history by its `name`) of the first case over time (x) and place ξ (y).

    Beside the whole record stands its first part, where the first waves run to and fro and the record is much longer
    than that; on a given `ax` only the whole record. A column that stands for several samples shows at each place the one
    of largest magnitude, so that no peak is lost. Needs points along all of the beam.
    """
    ds = chosen(ds, cases=cases)
    require(ds, name, "time", "point_position")
    case, note = one_case(ds)
    require_numbers(case[name].values, name)
    start = None if ax is not None else first_part(case)
    xi, history = whole_line(case, name)
    held = samples_held(case, name)
    ends = [end for end in (start, float(case["time"][held - 1])) if end is not None]
    thinned = f"at each place the value of largest magnitude in each of {TIMES} columns of time" if held > TIMES else ""
    columns = columns_for(len(ends))
    sheet = sheet_for(ax, len(ends) // columns, columns, width=6.4 if len(ends) == 1 else 9.6, height=3.6)
    for axes, end in zip(sheet.axes, ends):
        shown = case["time"].values[:held] <= end
        _draw(axes, case, name, (xi, case["time"].values[:held][shown], history[:held][shown]))
        axes.set_ylabel(r"Place $\xi$ (0 root, 1 tip)")  # on each, or the words of the bar before it would be taken for it
    return sheet.finish(ds, [note, end_note([case], name), thinned], warning=error_warning([case], name))


def _draw(axes: Axes, case: xr.Dataset, name: str, line: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    """One image of places, times and histories (time, point), with its own scale of colours."""
    xi, time, history = line
    places = np.linspace(xi[0], xi[-1], PLACES) if name in FORCES else places_of_line(case, xi, PLACES)
    image = largest_of_each(lambda part: _line(case, name, xi, history[part])(places), time.size, TIMES, BLOCK)
    words, image, factor = _scaled(case, name, image)
    clock, ticks = si_prefix(time, units_of(case["time"]))
    step = time[1] - time[0] if time.size > 1 else 1.0
    extent = (ticks * (time[0] - step / 2), ticks * (time[-1] + step / 2), places[0], 1.0)
    largest = np.abs(image).max() or 1.0
    look = {"cmap": "RdBu_r", "vmin": -largest, "vmax": largest, "interpolation": "nearest"}
    shown = axes.imshow(image, origin="lower", aspect="auto", extent=extent, **look)
    mark_places(axes, case, "y")
    axes.grid(visible=False)
    axes.set_xlabel(axis_label(case["time"], clock))
    bar = axes.figure.colorbar(shown, ax=axes, label=words, pad=0.02)
    if image.any():  # white is zero; no colours of a sign that does not occur
        bar.ax.set_ylim(image.min(), image.max())
        if name == "bending_moment" and not grows(case):
            _add_stress(bar.ax, case, factor)
    axes.set_title("", pad=6.0 + ROW * mark_events(axes, [case], ticks, words=True))


def _line(case: xr.Dataset, name: str, xi: np.ndarray, history: np.ndarray) -> Line:
    """Line of the beam through `history` (time, point)."""
    return force_line(xi, history) if name in FORCES else beam_line(case, xi, history)


def _add_stress(bar: Axes, case: xr.Dataset, scale: float) -> None:
    """The stress of the outermost fibre at the left of a bar of moments times `scale`, where all of the beam has one section."""
    try:
        of_moment = factors(case, "stress")
    except (KeyError, NothingToDraw):
        return
    if np.ptp(of_moment) > ALIKE * of_moment[0]:
        return
    prefix, times = si_prefix(np.array(bar.get_ylim()) / scale * of_moment[0], "Pa")
    factor = of_moment[0] * times / scale
    left = bar.secondary_yaxis("left", functions=(lambda value: value * factor, lambda value: value / factor))
    left.set_ylabel(f"Outermost fibre's stress ({prefix}Pa)")


def _scaled(case: xr.Dataset, name: str, image: np.ndarray) -> tuple[str, np.ndarray, float]:
    """Words for the colours of `image` (place, time), its numbers, of a growing motion over the largest so far, and their unit's factor."""
    if grows(case):
        largest = np.maximum.accumulate(np.abs(image).max(axis=0))
        words = f"{axis_label(case[name]).split(' (')[0]} over the largest so far: it grows"
        return words, image / np.where(largest > 0.0, largest, 1.0), 1.0
    prefix, factor = si_prefix(image, units_of(case[name]))
    return axis_label(case[name], prefix), factor * image, factor
