"""Events (impact, capture, release, contacts) as marks on a time axis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from .labels import flag_words
from .style import GREY


class Event(NamedTuple):
    """One event: begin and end (s; the same for what takes no time), kind in words, impulse on the tip (N s)."""

    time: float
    end: float
    kind: str
    impulse: float


ROW = 11  # height of a row of words, points


def mark_events(axes: Axes, cases: list[xr.Dataset], factor: float, *, words: bool) -> int:
    """Draw a line at each `event_time` (s, times `factor`) of `cases`; in `words`, name each kind once, in how many rows."""
    named: set[str] = set()
    rows = 0
    room = -np.inf  # where the last word ends, in pixels
    for time, kinds in sorted(_kinds_by_time(cases).items()):
        axes.axvline(time * factor, color=GREY, linewidth=0.9, linestyle=(0, (1, 2)), zorder=0)
        name = ", ".join(kinds)
        if words and name not in named:
            named.add(name)
            start = float(axes.get_xaxis_transform().transform((time * factor, 1.0))[0])
            row = int(start < room)  # a word that would cover the one before it stands below it
            word = axes.annotate(
                name,
                (time * factor, 1.0),
                xycoords=axes.get_xaxis_transform(),
                xytext=(3, -2 - ROW * row),
                textcoords="offset points",
                va="top",
                fontsize="small",
                color="0.3",
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1},
                zorder=0.5,  # before the lines of other events, behind the histories
            )
            room = max(room, word.get_window_extent().x1)
            rows = max(rows, row + 1)
    return rows


def leave_room(axes: Axes, rows: int) -> None:
    """Raise the top of the axis for what `mark_events` wrote; the usual margin is as high as one row."""
    if rows < 2:
        return
    height = axes.bbox.height * 72 / axes.figure.dpi
    scale = axes.yaxis.get_transform()
    low, high = scale.transform(np.array(axes.get_ylim()))
    share = ROW * (rows - 1) / height
    axes.set_ylim(top=float(scale.inverted().transform(np.array([low + (high - low) / (1 - share)]))[0]))


def _kinds_by_time(cases: list[xr.Dataset]) -> dict[float, list[str]]:
    """Names of the kinds of event at each instant, over all `cases`; empty without events."""
    found: dict[float, list[str]] = {}
    for case in cases:
        for event in events_of(case):
            kinds = found.setdefault(event.time, [])
            if event.kind not in kinds:
                kinds.append(event.kind)
    return found


def events_of(case: xr.Dataset) -> list[Event]:
    """Return the events of one case in the order of the file; an event without an end in the record ends never."""
    if "event_time" not in case or "event_kind" not in case:
        return []
    meanings = {value: word.replace("_", " ") for value, word in flag_words(case["event_kind"]).items()}
    times, kinds = case["event_time"].values, case["event_kind"].values
    ends = case["event_end"].fillna(np.inf).values if "event_end" in case else times
    impulses = case["event_impulse"].fillna(0.0).values if "event_impulse" in case else np.zeros(times.size)
    return [
        Event(float(time), float(end), meanings.get(int(kind), f"event {int(kind)}"), float(impulse))
        for time, end, kind, impulse in zip(times, ends, kinds, impulses)
        if np.isfinite(time) and np.isfinite(kind)
    ]
