"""Time and memory of `beamwave run` along axes: what grows, each size a process of its own."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Sequence

import numpy as np

from .bench import Rows
from .measuring import in_turns, median, run_scene

ROUNDS = 5
FEWER = ((5.0, 1),)  # what takes longer than this, s, is run so many times
LARGEST = 3  # sizes that the slope is taken over
COSTS = (("cpu_seconds", "CPU time (s)", 1.0), ("memory_bytes", "Peak of memory (MB)", 1e-6))


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


def powers(axis: Axis, rows: Rows) -> list[Any]:
    """Cells of an axis: its name, what stays, the largest size, the powers of time and memory."""
    own = axis.rows(rows)
    return [axis.name, axis.besides, f"{own[-1]['size']}", *(f"{slope(own, cost):.2f}" for cost, _, _ in COSTS)]
