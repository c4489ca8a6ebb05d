"""Error against seconds, a curve for each scene, from the measured rows alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from beamwave_postproc.style import COLOURS, GREY, RC
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .table import AIM

STYLES = ((COLOURS[1], "o"), (COLOURS[2], "s"))


def draw(measured: dict[str, Any]) -> Figure:
    """Tolerances as lines with marks, counts as marks alone, what a digit may cost beside each."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(7.0, 4.4), layout="constrained")
        axes = figure.subplots()
        for samples, style in zip(measured["against"], STYLES):
            rows = [row for row in measured["rows"] if row["samples"] == int(samples) and row.get("error", 0.0) > 0.0]
            scene(axes, [row for row in rows if "seconds" in row], int(samples), style)
        axes.set(xscale="log", yscale="log", xlabel="Largest error of the displacement over its peak",
                 ylabel="Time to the histories (ms)")  # fmt: skip
        axes.plot([], [], color=GREY, linestyle=":", label=f"{AIM:.0%} more time for each digit")
        axes.invert_xaxis()
        axes.legend(fontsize=9, loc="upper left")
    return figure


def scene(axes: Axes, rows: list[dict[str, Any]], samples: int, style: tuple[str, str]) -> None:
    """The curves of one scene."""
    colour, marker = style
    for ladder, line, filled, label in (
        ("tolerance", "-", colour, f"tolerance, {samples} samples"),
        ("counts", "none", "white", f"counts, {samples} samples"),
    ):
        mine = [row for row in rows if row["ladder"] == ladder]
        if not mine:
            continue
        error = np.array([row["error"] for row in mine])
        seconds = np.array([row["seconds"] for row in mine])
        axes.plot(error, 1e3 * seconds, color=colour, linestyle=line, marker=marker, markersize=5, markerfacecolor=filled,
                  label=label)  # fmt: skip
        if ladder == "tolerance":
            reach = np.geomspace(error[0], error.min(), 50)
            axes.plot(reach, 1e3 * seconds[0] * (1.0 + AIM) ** np.log10(error[0] / reach), color=GREY, linestyle=":")


def save(measured: dict[str, Any], path: Path) -> None:
    """Write the PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draw(measured).savefig(path, dpi=150, metadata={"Software": None})
