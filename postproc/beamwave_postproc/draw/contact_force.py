"""The force of a contact that lasts, and how mass and beam move meanwhile."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..parts.contacts import Contact, contacts_of, mass_at_beam
from ..parts.events import ROW, events_of, mark_events
from ..parts.labels import axis_label
from ..parts.passage import blow_at
from ..parts.places import turn_of_line
from ..parts.select import one_case
from ..parts.sheet import Given, columns_for, mosaic_for
from ..parts.units import si_prefix, units_of, with_unit
from ..result import require
from ..style import COLOURS, styled

MOST = 4  # contacts that have axes of their own, or a name
NAMED = 0.25  # of the largest force: a contact that reaches it has a name
# Colours of contacts in their order, told apart by the colour-blind too, without those too light for a line.
ORDER = LinearSegmentedColormap.from_list("order", colormaps["viridis"](np.linspace(0.0, 0.85, 64)))
WIDTH = 1.8  # inches, of one of them
ROOM = 1.5  # times the end of the last contact, up to which mass and beam are followed
LEAST = 24  # samples of the beam that are drawn at least
SAME_PLACE = 1e-9
FINE = 2000  # moments at which they are drawn


@styled
def contact_force(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw the force over time of every contact: of a few each on axes of its own, of more all on one, with colours in their order.

    All have one scale of forces; of many the hardest are named. Below them stand mass and beam at the
    struck place, where that is one of the points and no base moves the mass, too. Of a sweep the first case is drawn.
    """
    require(ds, "contact_force")
    case, note = one_case(ds)
    contacts = contacts_of(case)
    point = _struck_point(case)
    each = len(contacts) <= columns_for(MOST, MOST, WIDTH)
    letters = "".join(chr(ord("A") + i) for i in range(len(contacts) if each else 1))
    layout, ratios = ([letters], [1.0]) if point is None else ([letters, "z" * len(letters)], [1.0, 1.1])
    sheet = mosaic_for(ax, layout, ratios, width=max(6.4, 2.3 * len(letters)), height=2.8 * len(layout))
    if each:
        _draw_forces(sheet.axes[: len(contacts)], case, contacts)
    else:
        note = "; ".join(filter(None, [note, _draw_together(sheet.axes[0], contacts)]))
    if point is not None:
        _draw_motion(sheet.axes[-1], case, point, contacts[-1].time[-1])
    return sheet.finish(case, [note])


def _draw_together(axes: Axes, contacts: list[Contact]) -> str:
    """Forces of all contacts over the time since the begin of each, the smallest on top; which are named, in words."""
    strongest = sorted(contacts, key=lambda contact: contact.force.max(), reverse=True)
    peak = strongest[0].force.max()
    named = [contact for contact in strongest[:MOST] if contact.force.max() >= NAMED * peak]
    prefix, factor = si_prefix(np.array([peak]), "N")
    longest = max(contact.time[-1] - contact.time[0] for contact in contacts)
    clock, ticks = si_prefix(np.array([longest]), "s")
    colours = ScalarMappable(Normalize(1, contacts[-1].number), ORDER)
    for contact in strongest:
        words = f"contact {contact.number}, at {with_unit(float(contact.time[0]), 's', 3)}: {with_unit(contact.impulse, 'N s', 3)}"
        look = {"linewidth": 1.6, "label": words} if any(contact is one for one in named) else {"linewidth": 0.8}
        axes.plot(ticks * (contact.time - contact.time[0]), factor * contact.force, color=colours.to_rgba(contact.number), **look)
    axes.set(xlim=(0.0, ticks * longest), ylim=(0.0, 1.08 * factor * peak), xlabel=f"Time in contact ({clock}s)")
    axes.set_ylabel(f"Contact force ({prefix}N)")
    axes.figure.colorbar(colours, ax=axes, label="Contact", pad=0.02, ticks=MaxNLocator(6, integer=True))
    return f"{len(contacts)} contacts" + ", named those of the largest force, with their impulse"


def _draw_forces(row: list[Axes], case: xr.Dataset, contacts: list[Contact]) -> None:
    """Force of each contact over the time since its begin."""
    peak = max(contact.force.max() for contact in contacts)
    prefix, factor = si_prefix(np.array([peak]), "N")
    clock, ticks = si_prefix(np.array([contact.time[-1] - contact.time[0] for contact in contacts]), "s")
    for axes, contact in zip(row, contacts):
        since = contact.time - contact.time[0]
        axes.plot(ticks * since, factor * contact.force, color=COLOURS[2])
        axes.fill_between(ticks * since, 0.0, factor * contact.force, color=COLOURS[2], alpha=0.2, linewidth=0.0)
        begin = with_unit(float(contact.time[0]), "s", 3)
        axes.set_title(f"contact {contact.number}, at {begin}\nimpulse {with_unit(contact.impulse, 'N s', 3)}")
        axes.set(xlim=(0.0, ticks * since[-1]), ylim=(0.0, 1.08 * factor * peak), xlabel=f"Time in contact ({clock}s)")
        if axes is not row[0]:
            axes.tick_params(labelleft=False)
    row[0].set_ylabel(f"Contact force ({prefix}N)")


def _draw_motion(axes: Axes, case: xr.Dataset, point: int, end: float) -> None:
    """Positions of the mass and of the beam where it strikes, from the blow to some time after the last contact or the capture."""
    time, beam = case["time"].values, case["displacement"].values[point] + turn_of_line(case, point)
    end = min(max(ROOM * end, time[min(LEAST, time.size) - 1]), time[-1])
    moments = np.linspace(0.0, end, FINE)
    mass = mass_at_beam(case, moments, np.interp(moments, time, beam), beam[0])
    prefix, factor = si_prefix(np.concatenate([mass, beam[time <= end]]), units_of(case["displacement"]))
    clock, ticks = si_prefix(np.array([end]), "s")
    axes.plot(ticks * moments, factor * mass, color=COLOURS[2], label="mass")
    axes.plot(ticks * time[time <= end], factor * beam[time <= end], color=COLOURS[1], linestyle="--", label="beam at the struck place")
    axes.set(xlim=(0.0, ticks * end), xlabel=axis_label(case["time"], clock), ylabel=f"Position ({prefix}m)")
    captured = any(event.kind == "capture" for event in events_of(case))
    axes.set_title("", pad=6.0 + ROW * mark_events(axes, [case], ticks, words=captured))


def _struck_point(case: xr.Dataset) -> int | None:
    """Index of the point at which the mass strikes; None where histories have none, or the way of the mass is not known."""
    if "applied_acceleration" in case or "displacement" not in case or "point_position" not in case:
        return None
    near = np.flatnonzero(np.abs(case["point_position"].values - blow_at(case)) < SAME_PLACE)
    return int(near[0]) if near.size and np.isfinite(case["displacement"].values[near[0]]).all() else None
