"""The work–precision diagram, from the measured rows alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from beamwave_postproc.style import COLOURS, RC
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .measure import PEERS

LOOKS = {  # colour, dash, marker
    "beamwave": (COLOURS[2], "-", "o"),
    "beamwave, whole process": (COLOURS[2], (0, (4, 2)), "o"),
    "numpy + FINUFFT": (COLOURS[1], "-", "s"),
    "numpy, matrix products": (COLOURS[5], "-", "D"),
    "numpy, direct sum": (COLOURS[5], (0, (4, 2)), "d"),
    "textbook cosh shapes": (COLOURS[7], "-", "X"),
    "Hermite elements, exact modes": (COLOURS[3], "-", "^"),
    "Hermite elements, Newmark": (COLOURS[3], (0, (4, 2)), "v"),
    "OpenSees, Newmark": (COLOURS[4], "-", "P"),
}
LABELS = {  # words, at which of the curve's sizes, how far from it in points, and how they are aligned
    "beamwave": ("beamwave", -1, (-8, 0), "right"),
    "beamwave, whole process": ("beamwave, whole\nprocess with files", -2, (9, 0), "left"),
    "numpy + FINUFFT": ("numpy +\nFINUFFT", 4, (9, 0), "left"),
    "numpy, matrix products": ("numpy, matrix\nproducts", -1, (7, 0), "left"),
    "numpy, direct sum": ("numpy,\ndirect sum", -1, (7, 0), "left"),
    "textbook cosh shapes": ("textbook cosh shapes:\ncancel from mode 12,\noverflow from 227", 0, (-34, -20), "right"),
    "Hermite elements, exact modes": ("Hermite elements,\nexact modes", -1, (8, -4), "left"),
    "Hermite elements, Newmark": ("Hermite elements, Newmark", 0, (6, 10), "left"),
    "OpenSees, Newmark": ("OpenSees, Newmark", 1, (0, 10), "left"),
}
ROOM_FOR_WORDS = 12
BEHIND_WORDS = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}


def draw(measured: dict[str, Any]) -> Figure:
    """Error over peak against CPU seconds."""
    return diagram(measured["rows"], [peer.name for peer in PEERS], LOOKS, LABELS, title(measured["problem"]))


def diagram(rows: list[dict[str, Any]], names: list[str], looks: dict[str, tuple], labels: dict[str, tuple], words: str) -> Figure:
    """The curve of each name, with its look and label, under a title."""
    with mpl.rc_context({**RC, "font.size": 10.0}):
        figure = Figure(figsize=(8.6, 5.8), layout="constrained")
        axes = figure.subplots()
        axes.set(xscale="log", yscale="log")
        for name in names:
            curve(axes, [row for row in rows if row["peer"] == name], looks[name], labels[name])
        axes.set_xlabel("CPU time of one thread (s)")
        axes.set_ylabel("Largest error of the displacement over its peak")
        left, right = axes.get_xlim()
        axes.set_xlim(left / ROOM_FOR_WORDS, right)
        axes.set_ylim(bottom=axes.get_ylim()[0] / 3)
        axes.set_title(words, loc="left", fontsize=10)
    return figure


def title(problem: dict[str, Any]) -> str:
    """What was asked for."""
    return (
        rf"The beam after the capture, $\gamma$ = 0.2, $\omega$ = 50 rad s$^{{-1}}$: "
        f"midpoint and tip at {problem['samples']} times"
    )


def curve(axes: Axes, rows: list[dict[str, Any]], look: tuple, label: tuple) -> None:
    """One peer with its label; sizes without a number are left out."""
    known = [row for row in rows if row.get("error")]
    if not known:
        return
    colour, dash, marker = look
    seconds, errors = [row["cpu_seconds"] for row in known], [row["error"] for row in known]
    axes.plot(seconds, errors, color=colour, linestyle=dash, marker=marker, markerfacecolor="white", linewidth=1.6)
    words, size, offset, aligned = label
    size = max(-len(known), min(size, len(known) - 1))  # a small run has fewer
    axes.annotate(words, (seconds[size], errors[size]), xytext=offset, textcoords="offset points", ha=aligned,
                  va="center", color=colour, fontsize=9, bbox=BEHIND_WORDS)  # fmt: skip


def save(measured: dict[str, Any], path: Path) -> None:
    """Write the PNG."""
    save_figure(draw(measured), path)


def save_figure(figure: Figure, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150, metadata={"Software": None})
