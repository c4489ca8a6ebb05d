"""Errors over the bound and time of each tool, from the measured rows alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from beamwave_postproc.style import COLOURS, RC
from matplotlib.figure import Figure

MARKS = "osD^v"


def draw(measured: dict[str, Any]) -> Figure:
    """A line for each kind of record; at the left the error of the frequency, at the right the time."""
    rows = [row for row in measured["rows"] if "draws" in row]  # those with lines
    cells = list(dict.fromkeys(row["cell"] for row in rows))[::-1]
    with mpl.rc_context(RC):
        figure = Figure(figsize=(8.6, 0.9 + 0.32 * len(cells)), layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True)
        for number, peer in enumerate(dict.fromkeys(row["peer"] for row in rows)):
            own = [row for row in rows if row["peer"] == peer]
            style = {"color": COLOURS[number], "marker": MARKS[number], "linestyle": "none", "markersize": 4}
            known = [row for row in own if row["over_bound"]]
            left.plot([row["over_bound"][0] for row in known], [cells.index(row["cell"]) for row in known], label=peer, **style)
            right.plot([row["milliseconds"] for row in own], [cells.index(row["cell"]) for row in own], **style)
        left.axvline(1.0, color="0.6", linewidth=0.8)
        left.set_yticks(range(len(cells)), cells)
        for axes, words in ((left, "Square error of the frequency / bound"), (right, "CPU time of a record (ms)")):
            axes.set_xscale("log")
            axes.set_xlabel(words)
        figure.legend(loc="outside upper center", ncols=5, frameon=False)
    return figure


def save(measured: dict[str, Any], path: Path) -> None:
    """Write the picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draw(measured).savefig(path, dpi=150)
