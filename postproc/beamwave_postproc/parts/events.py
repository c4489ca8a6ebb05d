"""Events (impact, capture, release, contacts) as marks on a time axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.transforms import ScaledTranslation

from ..style import ABOVE_GRID, GREY
from .labels import flag_words

ROW = 11.0  # height of a row of words, points
RISE = 4.0  # of the lowest row above the axes, points
GAP = 4.0  # between words of one row, points
LASTING: dict[str, Any] = {"color": "0.88", "zorder": 0}  # look of a span of time
ABOVE: dict[str, Any] = {"color": "0.55", "clip_on": False}
STRIP = 0.018  # of the height of an image, over which spans stand, so that it is seen
LANE, BAR = 4.0, 2.6  # of the events of one of several cases above the axes: from one to the next, and height, points


class Event(NamedTuple):
    """One event: begin and end (s; the same for what takes no time), kind in words, impulse on the beam (N s)."""

    time: float
    end: float
    kind: str
    impulse: float


def events_of(case: xr.Dataset) -> list[Event]:
    """Return the events of one case in the order of the file; an event without an end in the record ends never."""
    if "event_time" not in case or "event_kind" not in case:
        return []
    meanings = {value: word.replace("_", " ") for value, word in flag_words(case["event_kind"]).items()}
    times, kinds = case["event_time"].values, case["event_kind"].values
    ends = np.nan_to_num(case["event_end"].values, nan=np.inf) if "event_end" in case else times
    impulses = np.nan_to_num(case["event_impulse"].values) if "event_impulse" in case else np.zeros(times.size)
    return [
        Event(float(time), float(end), meanings.get(int(kind), f"event {int(kind)}"), float(impulse))
        for time, end, kind, impulse in zip(times, ends, kinds, impulses)
        if np.isfinite(time) and np.isfinite(kind)
    ]


def mark_events(
    axes: Axes, cases: list[xr.Dataset], factor: float, *, words: bool, alike: bool = False, colours: Sequence[str] = ()
) -> float:
    """Draw each event of `cases` (s, times `factor`) as a line, or as a span where it lasts.

    With `alike` only those that all cases share are drawn, as lines. Events that differ between cases with `colours` stand
    above the axes with `words`, each case in a lane of its own. With `words` each kind is named once above all that, where
    it first happens; of a single case with how many there are. Returns the height of what stands there, in rows of words.
    """
    first, last = axes.get_xlim()
    owners = {event: range(len(cases)) for event in _common(cases)} if alike else _owners(cases)
    shown = [event for event in sorted(owners, key=lambda event: event.time) if first <= event.time * factor <= last]
    own = [event for event in shown if colours and len(owners[event]) < len(cases)]
    for event in shown:
        start, end = event.time * factor, min(event.end * factor, last)
        if event not in own:
            _draw(axes, start, end)
        elif words:
            _draw_in_lanes(axes, start, end, {len(cases) - 1 - case: colours[case] for case in owners[event]})
    if not words:
        return 0.0
    lanes = LANE * len(cases) if own else 0.0
    return _write(axes, _names(shown, factor, counted=len(cases) == 1), RISE + lanes) + lanes / ROW


def lanes_note(cases: list[xr.Dataset]) -> str:
    """What the lanes of `mark_events` are, where there are any."""
    differ = [event for event, owners in _owners(cases).items() if len(owners) < len(cases)]
    kinds = " and ".join(sorted({f"{event.kind}s" for event in differ}))
    return f"{kinds} of each case above the axes" if kinds else ""


def _owners(cases: list[xr.Dataset]) -> dict[Event, list[int]]:
    """The events of all cases, each once, with the numbers of the cases that have it, whatever its impulse there."""
    found: dict[Event, list[int]] = {}
    for number, case in enumerate(cases):
        for event in dict.fromkeys(one._replace(impulse=0.0) for one in events_of(case)):
            found.setdefault(event, []).append(number)
    return found


def _common(cases: list[xr.Dataset]) -> list[Event]:
    """Events of one time and kind in all cases, as moments: how long they last differs."""
    keys = [{(event.time, event.kind) for event in events_of(case)} for case in cases]
    return [Event(time, time, kind, 0.0) for time, kind in set.intersection(*keys)]


def _draw(axes: Axes, start: float, end: float) -> None:
    """A line at `start`, and a span to `end` where that is later; the limits of the axes stay as they are."""
    whole = axes.get_xaxis_transform()
    if end > start:
        bottom, height, look = (1.0, STRIP, ABOVE) if axes.images else (0.0, 1.0, LASTING)
        axes.add_artist(Rectangle((start, bottom), end - start, height, transform=whole, linewidth=0.0, **look))
    line = Line2D(
        [start, start], [0.0, 1.0], transform=whole, color=GREY, linewidth=0.8, linestyle=(0, (1, 2)), zorder=ABOVE_GRID
    )
    axes.add_artist(line)


def _draw_in_lanes(axes: Axes, start: float, end: float, colours: dict[int, str]) -> None:
    """The same as a bar above the axes, of no length where it is a moment, in lanes of these numbers and colours."""
    for lane, colour in colours.items():
        up = ScaledTranslation(0.0, LANE * (lane + 0.75) / 72.0, axes.figure.dpi_scale_trans)
        look = {"color": colour, "clip_on": False, "transform": axes.get_xaxis_transform() + up}
        axes.add_artist(Line2D([start, end], [1.0, 1.0], linewidth=BAR, solid_capstyle="butt", **look))
        axes.add_artist(Line2D([start], [1.0], marker="|", markersize=BAR, **look))  # of a short one, too


def _names(events: list[Event], factor: float, *, counted: bool) -> dict[float, str]:
    """Kinds of `events`, with their numbers where `counted`, by the place at which each first happens."""
    kinds: dict[str, list[Event]] = {}
    for event in events:
        kinds.setdefault(event.kind, []).append(event)
    found: dict[float, str] = {}
    for kind, alike in kinds.items():
        lasting = sum(event.end > event.time for event in alike)
        name = f"{len(alike)} {kind}s" if counted and len(alike) > 1 else kind
        some = f"{lasting} " if counted and lasting < len(alike) else ""
        name += f" ({some}lasting)" if lasting else ""
        place = alike[0].time * factor
        found[place] = f"{found[place]}, {name}" if place in found else name
    return found


def _write(axes: Axes, names: dict[float, str], rise: float) -> int:
    """Names `rise` points above the axes, in the lowest row in which each has room; how many rows that takes."""
    free: list[float] = []  # where the last word of each row ends, in pixels
    for time, name in sorted(names.items()):
        word = axes.annotate(
            name,
            (time, 1.0),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0.0, rise),
            textcoords="offset points",
            ha="left",
            va="bottom",
            fontsize=8.5,
            color="0.3",
        )
        box = word.get_window_extent()
        start = float(axes.get_xaxis_transform().transform((time, 1.0))[0])
        row = next((i for i, end in enumerate(free) if start > end), len(free))
        free[row : row + 1] = [start + box.width + GAP * axes.figure.dpi / 72.0]
        word.set_position((0.0, rise + ROW * row))
    return len(free)
