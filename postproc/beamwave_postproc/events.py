"""Events (impact, capture, release, contacts) as marks on a time axis."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from .style import GREY


def mark_events(axes: Axes, cases: list[xr.Dataset], factor: float, *, words: bool) -> None:
    """Draw a line at each `event_time` (s, times `factor`) of `cases`; in `words`, name each kind once."""
    named: set[str] = set()
    for time, kinds in sorted(_kinds_by_time(cases).items()):
        axes.axvline(time * factor, color=GREY, linewidth=0.9, linestyle=(0, (1, 2)), zorder=0)
        name = ", ".join(kinds)
        if words and name not in named:
            named.add(name)
            axes.annotate(
                name,
                (time * factor, 1.0),
                xycoords=axes.get_xaxis_transform(),
                xytext=(3, -2),
                textcoords="offset points",
                va="top",
                fontsize="small",
                color="0.3",
            )


def _kinds_by_time(cases: list[xr.Dataset]) -> dict[float, list[str]]:
    """Names of the kinds of event at each instant, over all `cases`; empty without events."""
    found: dict[float, list[str]] = {}
    for case in cases:
        if "event_time" not in case or "event_kind" not in case:
            continue
        meanings = _meanings(case["event_kind"])
        for time, kind in zip(case["event_time"].values, case["event_kind"].values):
            if np.isfinite(time) and np.isfinite(kind):
                kinds = found.setdefault(float(time), [])
                name = meanings.get(int(kind), f"event {int(kind)}")
                if name not in kinds:
                    kinds.append(name)
    return found


def _meanings(kind: xr.DataArray) -> dict[int, str]:
    """CF flags of `event_kind`: value to word."""
    words = str(kind.attrs.get("flag_meanings", "")).split()
    values = np.atleast_1d(kind.attrs.get("flag_values", []))
    return {int(value): word.replace("_", " ") for value, word in zip(values, words)}
