"""The impulses of the blows and contacts of a mass that bounces."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.bands import is_scattered
from ..parts.curves import Curve, panels_of
from ..parts.events import Event, events_of
from ..parts.labels import axis_label
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, sheet_for
from ..parts.units import si_prefix, units_of
from ..result import NothingToDraw, require
from ..style import styled

ROOM = 1.3  # times the end of the last contact, up to which time is drawn


@styled
def impulses(ds: xr.Dataset, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `event_impulse` (N s) of the impact and of each contact at its time, as wide as it lasts.

    Raises `NothingToDraw` unless a case has two impulses or more, and of a design, unless few of its `cases` are chosen.
    """
    ds = chosen(ds, cases=cases)
    require(ds, "event_time", "event_kind", "event_impulse")
    if is_scattered(ds):
        raise NothingToDraw("cases that vary several inputs at once: choose some of them with cases")
    drawn = panels_of(ds, "event_impulse", panels=1)
    blows = [[event for event in events_of(curve.data) if event.impulse != 0.0] for curve in drawn.curves]
    if max(len(events) for events in blows) < 2:
        raise NothingToDraw("there are not two impulses or more")
    sheet = sheet_for(ax, height=3.2)
    axes = sheet.axes[0]
    last = max(_end(ds), *(event.time for events in blows for event in events))
    latest = max(min(event.end, last) for events in blows for event in events)
    shown = min(last, ROOM * latest)
    clock, ticks = si_prefix(np.array([shown]), units_of(ds["event_time"]))
    prefix, factor = si_prefix(
        np.array([event.impulse for events in blows for event in events]), units_of(ds["event_impulse"])
    )
    for curve, events in zip(drawn.curves, blows):
        _draw(
            axes,
            curve,
            [
                event._replace(
                    time=ticks * event.time, end=ticks * min(event.end, last), impulse=factor * event.impulse
                )
                for event in events
            ],
        )
    axes.axhline(0.0, color="0.3", linewidth=0.8)
    axes.margins(y=0.1)
    axes.set_xlim(-0.015 * ticks * shown, 1.015 * ticks * shown)
    axes.set(xlabel=f"Time $t$ ({clock}s)", ylabel=axis_label(ds["event_impulse"], prefix))
    contacts = sum(event.kind == "contact" for event in blows[0])
    counts = f"{contacts} contacts" if len(blows) == 1 else ""
    return sheet.finish(ds, [*drawn.notes, counts])


def _end(ds: xr.Dataset) -> float:
    """The last moment (s) of which a case has a number; 0 without histories."""
    if "displacement" not in ds or "time" not in ds:
        return 0.0
    held = ds["displacement"].notnull().any([dim for dim in ds["displacement"].dims if dim != "time"])
    return float(ds["time"].values[held.values].max(initial=0.0))


def _draw(axes: Axes, curve: Curve, events: list[Event]) -> None:
    """Stems with a marker; of a single case a span for what lasts."""
    colour = curve.style["color"]
    for event in events if not curve.label else ():  # spans of several cases would hide each other
        if event.end > event.time:
            axes.fill_between([event.time, event.end], 0.0, event.impulse, color=colour, alpha=0.2, linewidth=0.0)
    times, sizes = [event.time for event in events], [event.impulse for event in events]
    axes.vlines(times, 0.0, sizes, color=colour, linewidth=0.9)
    axes.plot(times, sizes, label=curve.label or None, **{**curve.style, "linestyle": ""})
