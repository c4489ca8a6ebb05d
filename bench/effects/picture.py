"""Instructions and seconds as bars, from the measured rows alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from beamwave_postproc.style import COLOURS, RC
from matplotlib.figure import Figure

METHODS = (None, "closed form", "galerkin", "pieces")  # each has a colour
COSTS = (("instructions", "Instructions (millions)", 1e-6), ("seconds", "Time (ms)", 1e3))


def draw(measured: dict[str, Any]) -> Figure:
    """Two axes side by side."""
    rows = measured["rows"][::-1]
    with mpl.rc_context(RC):
        figure = Figure(figsize=(8.6, 3.8), layout="constrained")
        for axes, (cost, words, scale) in zip(figure.subplots(1, 2, sharey=True), COSTS):
            values = [(row[cost] or 0.0) * scale for row in rows]
            colours = [COLOURS[METHODS.index(row["method"])] for row in rows]
            bars = axes.barh([row["variant"] for row in rows], values, color=colours)
            axes.bar_label(bars, [f"{value:.3g}" if value else "not counted" for value in values], padding=3, fontsize="small")
            axes.set_xlabel(words)
            axes.margins(x=0.15)
            axes.grid(visible=False)
        figure.suptitle("blue: modes in closed form; orange: by Galerkin's method; green: of pieces", fontsize="medium")
    return figure


def save(measured: dict[str, Any], path: Path) -> None:
    """Write the picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draw(measured).savefig(path, dpi=150)
