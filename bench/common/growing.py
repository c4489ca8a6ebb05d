"""Time and memory of `beamwave run` along axes: what grows, each size a process of its own."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Sequence

import matplotlib as mpl
import numpy as np
from beamwave_postproc.style import COLOURS, GREY, RC
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from .bench import Measured, Rows
from .document import measured_with, table
from .measuring import in_turns, median, run_scene

ROUNDS = 5
FEWER = ((5.0, 1),)  # what takes longer than this, s, is run so many times
LARGEST = 3  # sizes that the slope is taken over
ROOM_FOR_WORDS = 0.2
STYLES = ((COLOURS[1], "-", "o"), (COLOURS[2], (0, (4, 2)), "s"))
COSTS = (("cpu_seconds", "CPU time (s)", 1.0), ("memory_bytes", "Peak of memory (MB)", 1e-6))
Cell = Callable[[Any], str]


@dataclass(frozen=True)
class Axis:
    """What grows: its sizes, and the scene of each."""

    name: str
    besides: str  # what stays, for the figure and the table
    sizes: Sequence[int]
    small: Sequence[int]
    scene: Callable[[int], str]
    prepare: Callable[[Path, int], None] = lambda directory, size: None  # what lies beside the scene

    def rows(self, rows: Rows) -> Rows:
        """Its own."""
        return [row for row in rows if row["axis"] == self.name]


def measure(axes: Sequence[Axis], small: bool) -> Rows:
    """One row for each axis and size, with medians of times and the largest memory."""
    jobs = [(axis, size) for axis in axes for size in (axis.small if small else axis.sizes)]
    answers = in_turns(jobs, run, 1 if small else ROUNDS, lambda job: f"{job[0].name} {job[1]}", FEWER)
    rows = []
    for (axis, size), runs in zip(jobs, answers):
        seconds, wall, memory, result = zip(*runs)
        rows.append({
            "axis": axis.name,
            "size": size,
            "cpu_seconds": median(seconds),
            "wall_seconds": median(wall),
            "memory_bytes": max(memory),
            "result_bytes": max(result),
            "runs": len(runs),
        })
    return rows


def run(job: tuple[Axis, int]) -> tuple[float, float, int, int]:
    """CPU seconds, wall seconds, peak memory and the result's size in bytes."""
    axis, size = job
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        axis.prepare(directory, size)
        took = run_scene(directory, axis.scene(size))
        return *took[:3], (directory / "scene.nc").stat().st_size


def slope(rows: Rows, name: str) -> float:
    """The power of the size to which a cost grows, by least squares over the largest sizes.

    The cost of the smallest size is subtracted from those that are more than twice as large.
    """
    last = rows[-LARGEST:] if len(rows) > LARGEST else rows
    sizes = np.log([row["size"] for row in last])
    fixed = rows[0][name] if len(rows) > LARGEST else 0
    costs = [row[name] - fixed if row[name] > 2 * fixed else row[name] for row in last]
    return float(np.polyfit(sizes, np.log(costs), 1)[0])


def section(measured: Measured, words: str, axes: Sequence[Axis], growth: dict[str, Cell], sizes: dict[str, Cell]) -> list[str]:
    """Text, a table of the axes and one of all sizes; a cell of `growth` is made of the axis's rows, one of `sizes` of a row."""
    powers = [["varied", "fixed", "up to", "power of time", "power of memory", *growth]]
    for axis in axes:
        own = axis.rows(measured["rows"])
        slopes = [f"{slope(own, cost):.2f}" for cost, _, _ in COSTS]
        powers.append([axis.name, axis.besides, f"{own[-1]['size']}", *slopes, *(cell(own) for cell in growth.values())])
    all_sizes = [["grows", "size", "CPU s", *sizes, "runs"]]
    for row in measured["rows"]:
        cells = [f"{row['cpu_seconds']:.2g}", *(cell(row) for cell in sizes.values()), str(row["runs"])]
        all_sizes.append([row["axis"], str(row["size"]), *cells])
    return [words, measured_with(measured["machine"]), table(powers), "All sizes:", table(all_sizes)]


def megabytes(number: Callable[[dict[str, Any]], float]) -> Cell:
    """A cell of a number of bytes."""
    return lambda row: f"{number(row) / 1e6:.0f}"


def draw(rows: Rows, columns: Sequence[tuple[str, dict[str, str]]], limit: Callable[[dict[str, Any]], float], name: str) -> Figure:
    """Time above, memory with its limit below; a column has a label, and of each of its axes a note beside the slope."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(2.2 + 2.15 * len(columns), 5.4), layout="constrained")
        grid = figure.subplots(len(COSTS), len(columns), sharex="col", sharey="row")
        for line, (cost, words, scale) in enumerate(COSTS):
            grid[line, 0].set_ylabel(words)
            for axes, (label, curves) in zip(grid[line], columns):
                axes.set(xscale="log", yscale="log", xlabel=label if line else "")
                axes.xaxis.set_minor_locator(NullLocator())
                for number, ((axis, note), (colour, dash, marker)) in enumerate(zip(curves.items(), STYLES)):
                    own = [row for row in rows if row["axis"] == axis]
                    sizes = [row["size"] for row in own]
                    if cost == "memory_bytes":
                        axes.plot(sizes, [limit(row) * scale for row in own], color=GREY, linestyle=":", linewidth=1.4, label=name)
                    style = {"color": colour, "linestyle": dash, "marker": marker, "markerfacecolor": "white"}
                    axes.plot(sizes, [row[cost] * scale for row in own], **style)
                    power = f"slope {slope(own, cost):.2f}"
                    axes.text(0.98, 0.04 + 0.08 * number, f"{note}: {power}" if note else power, fontsize=9, ha="right",
                              color=colour, transform=axes.transAxes)  # fmt: skip
            grid[line, 0].set_ylim(bottom=min(row[cost] for row in rows) * scale * ROOM_FOR_WORDS)
        handles, labels = grid[-1, 0].get_legend_handles_labels()
        grid[-1, 0].legend(handles[:1], labels[:1], frameon=False, fontsize=9, loc="upper left")
    return figure
