"""Time and memory of a run against modes, samples and points."""

from __future__ import annotations

import argparse
from typing import Any

import matplotlib as mpl
from beamwave_postproc.style import COLOURS, GREY, RC
from common.bench import Bench, Measured, Rows
from common.document import measured_with, table
from common.growing import COSTS, LARGEST, Axis, measure, powers, slope
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

BOUND_FACTOR, BOUND_BYTES = 2, 200e6  # memory stays below twice the result and this

BASE = """\
&beam      length = 1, diameter = 0.037, density = 7870, youngs_modulus = 2e11 /
&rotation  angular_velocity = 50 /
&impact    mass_ratio = 0.2 /
&capture   /
"""


def counted(before: str, n: int) -> str:
    """A scene with so many modes."""
    return f"{BASE}&modes before = {before}, after = {n} /\n&response duration = 1, samples = 4096 /\n"


def tolerated(response: str) -> str:
    """A scene with a tolerance."""
    return f"{BASE}&modes tolerance = 1e-6 /\n&response duration = 1, {response} /\n"


def places(n: int) -> str:
    """So many points."""
    return ", ".join(f"{(i + 1) / n:.9g}" for i in range(n))


AXES = (
    Axis(
        "modes",
        "2 points, 4096 samples; one mode before the capture",
        (1000, 10_000, 100_000, 1_000_000, 3_000_000, 10_000_000),
        (100, 1000),
        lambda n: counted("1", n),
    ),
    Axis(
        "modes before and after",
        "2 points, 4096 samples",
        (100, 1000, 10_000, 100_000, 1_000_000, 3_000_000, 10_000_000),
        (10, 100),
        lambda n: counted(f"{n}", n),
    ),
    Axis(
        "samples",
        "2 points, tolerance 1e-6",
        [2**power for power in range(10, 25, 2)],
        (256, 1024),
        lambda n: tolerated(f"samples = {n}"),
    ),
    Axis(
        "points",
        "65 536 samples, tolerance 1e-6",
        (1, 3, 10, 30, 100, 300, 1000),
        (1, 10),
        lambda n: tolerated(f"samples = 65536, points = {places(n)}"),
    ),
)

WORDS = """\
## How time and memory grow

Made by `bench/growth.sh` ([bench/](../bench/README.md#growth) describes it). Each size is a run of `beamwave run` as a process of
its own. The tables give its CPU seconds, medians of up to {rounds} interleaved runs, and its peak memory. The first table gives
the power of the size to which a cost grows, from the largest {largest} sizes without start-up. The bound of the memory is
twice the result plus 200 MB.

![Time and memory against modes, samples and points](pictures/growth.png)
"""

COLUMNS = (  # what grows: curves, and words of each beside its slope
    ("Modes", (("modes", "1 before, all after"), ("modes before and after", "as many before"))),
    ("Samples", (("samples", ""),)),
    ("Points", (("points", ""),)),
)
ROOM_FOR_WORDS = 0.2
STYLES = ((COLOURS[1], "-", "o"), (COLOURS[2], (0, (4, 2)), "s"))


def bound(row: dict[str, Any]) -> float:
    """Bytes that a run may take."""
    return BOUND_FACTOR * row["result_bytes"] + BOUND_BYTES


def section(measured: Measured) -> list[str]:
    """Text, a table of the axes and one of all sizes."""
    rows = measured["rows"]
    words = WORDS.format(rounds=max(row["runs"] for row in rows), largest=LARGEST)
    growth = [["varied", "fixed", "up to", "power of time", "power of memory", "largest memory over its bound"]]
    for axis in AXES:
        part = max(row["memory_bytes"] / bound(row) for row in axis.rows(rows))
        growth.append([*powers(axis, rows), f"{part:.2f}"])
    sizes = [["grows", "size", "CPU s", "memory MB", "result MB", "bound MB", "runs"]]
    for row in rows:
        memory = [f"{value / 1e6:.0f}" for value in (row["memory_bytes"], row["result_bytes"], bound(row))]
        sizes.append([row["axis"], str(row["size"]), f"{row['cpu_seconds']:.2g}", *memory, str(row["runs"])])
    return [words, measured_with(measured["machine"]), table(growth), "All sizes:", table(sizes)]


def draw(measured: Measured) -> Figure:
    """Time above, memory below, one column for each axis."""
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
            axes.text(0.03, 3e-6 * BOUND_BYTES, "2 × result + 200 MB", color=GREY, fontsize=9,
                      transform=axes.get_yaxis_transform())  # fmt: skip
    return figure


def curve(axes: Axes, rows: Rows, cost: str, scale: float, number: int) -> None:
    """One axis's rows; memory with its bound."""
    colour, dash, marker = STYLES[number]
    sizes = [row["size"] for row in rows]
    if cost == "memory_bytes":
        axes.plot(sizes, [bound(row) * scale for row in rows], color=GREY, linestyle=":", linewidth=1.4)
    axes.plot(sizes, [row[cost] * scale for row in rows], color=colour, linestyle=dash, marker=marker,
              markerfacecolor="white")  # fmt: skip


def measured(options: argparse.Namespace) -> Measured:
    """All rows."""
    return {"rows": measure(AXES, options.small)}


BENCH = Bench("growth", "time and memory of a run", measured, section, draw)
