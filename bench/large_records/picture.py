"""Time above, memory below, one column for each axis, from the measured rows alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from beamwave_postproc.style import COLOURS, GREY, RC
from matplotlib.figure import Figure

from .records import AXES
from .table import record_bytes

COSTS = (("cpu_seconds", "CPU time (s)", 1.0), ("memory_bytes", "Peak of memory (MB)", 1e-6))


def save(measured: dict[str, Any], path: Path) -> None:
    """Write the PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(RC):
        figure = Figure(figsize=(6.4, 5.4), layout="constrained")
        grid = figure.subplots(len(COSTS), len(AXES), sharex="col", sharey="row")
        for line, (cost, words, scale) in enumerate(COSTS):
            grid[line, 0].set_ylabel(words)
            for axes, axis in zip(grid[line], AXES):
                rows = [row for row in measured["rows"] if row["axis"] == axis.name]
                sizes = [row["size"] for row in rows]
                axes.set(xscale="log", yscale="log", xlabel=f"{axis.name} ({axis.besides})" if line else "")
                axes.plot(sizes, [row[cost] * scale for row in rows], color=COLOURS[1], marker="o", markerfacecolor="white")
                if cost == "memory_bytes":
                    records = [record_bytes(row) * scale for row in rows]
                    axes.plot(sizes, records, color=GREY, linestyle=":", label="the record itself")
                    axes.legend(frameon=False, fontsize=9)
        figure.savefig(path, dpi=150, metadata={"Software": None})
