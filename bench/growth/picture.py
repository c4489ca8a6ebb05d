"""Time above, memory below, one column for each axis, from the measured rows alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from beamwave_postproc.style import COLOURS, GREY, RC
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from .slope import bound, slope

COLUMNS = (  # what grows: curves, and words of each beside its slope
    ("Modes", (("modes", "1 before, all after"), ("modes before and after", "as many before"))),
    ("Samples", (("samples", ""),)),
    ("Points", (("points", ""),)),
)
COSTS = (("cpu_seconds", "CPU time (s)", 1.0), ("memory_bytes", "Peak of memory (MB)", 1e-6))
ROOM_FOR_WORDS = 0.2
STYLES = ((COLOURS[1], "-", "o"), (COLOURS[2], (0, (4, 2)), "s"))


def draw(measured: dict[str, Any]) -> Figure:
    """Six axes."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(8.6, 5.4), layout="constrained")
        grid = figure.subplots(len(COSTS), len(COLUMNS), sharex="col", sharey="row")
        for line, (cost, words, scale) in enumerate(COSTS):
            grid[line, 0].set_ylabel(words)
            for axes, (label, curves) in zip(grid[line], COLUMNS):
                axes.set(xscale="log", yscale="log", xlabel=label if line else "")
                axes.xaxis.set_minor_locator(NullLocator())
                for number, (name, note) in enumerate(curves):
                    rows = [row for row in measured["rows"] if row["axis"] == name]
                    curve(axes, rows, cost, scale, number)
                    power = f"slope {slope(rows, cost):.2f}"
                    axes.text(0.98, 0.04 + 0.08 * number, f"{note}: {power}" if note else power, fontsize=9, ha="right",
                              color=STYLES[number][0], transform=axes.transAxes)  # fmt: skip
            grid[line, 0].set_ylim(bottom=min(row[cost] for row in measured["rows"]) * scale * ROOM_FOR_WORDS)
        for axes in grid[-1]:
            words = "2 × result + 200 MB"
            axes.text(0.03, bound({"result_bytes": 0}) * 3e-6, words, color=GREY, fontsize=9,
                      transform=axes.get_yaxis_transform())  # fmt: skip
    return figure


def curve(axes: Axes, rows: list, cost: str, scale: float, number: int) -> None:
    """One axis's rows; memory with its bound."""
    colour, dash, marker = STYLES[number]
    sizes = [row["size"] for row in rows]
    if cost == "memory_bytes":
        axes.plot(sizes, [bound(row) * scale for row in rows], color=GREY, linestyle=":", linewidth=1.4)
    axes.plot(sizes, [row[cost] * scale for row in rows], color=colour, linestyle=dash, marker=marker,
              markerfacecolor="white")  # fmt: skip


def save(measured: dict[str, Any], path: Path) -> None:
    """Write the PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draw(measured).savefig(path, dpi=150, metadata={"Software": None})
