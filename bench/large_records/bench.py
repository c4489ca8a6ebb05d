"""Time and memory of the lines of a record against its samples and sensors."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib as mpl
import netCDF4
import numpy as np
from beamwave_postproc.style import COLOURS, GREY, RC
from common.bench import Bench, Measured
from common.document import measured_with, table
from common.growing import COSTS, Axis, measure, powers
from matplotlib.figure import Figure

LINES = 20
RATE = 2048.0  # Hz
NOISE = 0.01  # of a typical amplitude
BLOCK = 2**16  # samples that are made at once
SEED = 5
SENSORS, SAMPLES = 64, 2**20  # which stay while the other grows
SMALL_SAMPLES = 2**14  # in a trial run

WORDS = """\
## Large records

Made by `bench/large_records.sh` ([bench/](../bench/README.md#large-records) describes it). Each size is a run of `beamwave run` as a
process of its own, on a record with {lines} lines in white noise. The tables give its CPU seconds, including reading, its peak memory,
and the size of the samples in double precision. If wall seconds are much larger, other work shared the cores, and
the CPU seconds are larger than on an idle machine, too.

![Time and memory against samples and sensors](pictures/large_records.png)
"""


def axes_of(samples: int) -> tuple[Axis, Axis]:
    """What grows; `samples` is how many there are while sensors grow."""

    def scene(_: int) -> str:
        return "&record\n  file = 'record.nc'\n/\n&spectrum /\n"

    def longer(directory: Path, size: int) -> None:
        write(directory / "record.nc", size, SENSORS)

    def wider(directory: Path, size: int) -> None:
        write(directory / "record.nc", samples, size)

    return (
        Axis("samples", "64 sensors", (2**14, 2**16, 2**18, 2**20), (4096, 16384), scene, longer),
        Axis("sensors", "1 048 576 samples", (1, 4, 16, 64), (1, 2), scene, wider),
    )


AXES = axes_of(SAMPLES)


def write(path: Path, samples: int, sensors: int) -> None:
    """Lines from 5 to 900 Hz that live through a third to all of the record, in single precision as recorders write it."""
    draws = np.random.default_rng(SEED)
    duration = samples / RATE
    rates = 2j * np.pi * np.sort(draws.uniform(5, 900, LINES)) - draws.uniform(5, 25, LINES) / duration
    amplitudes = draws.normal(size=(LINES, sensors))
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("time", samples)
        file.createDimension("sensor", sensors)
        time = file.createVariable("time", "f8", ("time",))
        time.units = "s"
        values = file.createVariable("acceleration", "f4", ("time", "sensor"))
        values.units = "m s-2"
        for first in range(0, samples, BLOCK):
            times = np.arange(first, min(first + BLOCK, samples)) / RATE
            time[first : first + BLOCK] = times
            motion = np.exp(np.outer(times, rates)).real @ amplitudes
            values[first : first + BLOCK] = motion + NOISE * draws.normal(size=motion.shape)


def record_bytes(row: dict[str, Any]) -> int:
    """The record in double precision."""
    return 8 * row["size"] * (SENSORS if row["axis"] == "samples" else SAMPLES)


def section(measured: Measured) -> list[str]:
    """Text, a table of both axes and one of all sizes."""
    rows = measured["rows"]
    growth = [["varied", "fixed", "up to", "power of time", "power of memory"]]
    growth += [powers(axis, rows) for axis in AXES]
    sizes = [["grows", "size", "CPU s", "wall s", "memory MB", "record MB", "runs"]]
    for row in rows:
        times = [f"{row['cpu_seconds']:.2g}", f"{row['wall_seconds']:.3g}"]
        memory = [f"{value / 1e6:.0f}" for value in (row["memory_bytes"], record_bytes(row))]
        sizes.append([row["axis"], str(row["size"]), *times, *memory, str(row["runs"])])
    words = WORDS.format(lines=LINES)
    return [words, measured_with(measured["machine"]), table(growth), "All sizes:", table(sizes)]


def draw(measured: Measured) -> Figure:
    """Time above, memory below, one column for each axis."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(6.4, 5.4), layout="constrained")
        grid = figure.subplots(len(COSTS), len(AXES), sharex="col", sharey="row")
        for line, (cost, words, scale) in enumerate(COSTS):
            grid[line, 0].set_ylabel(words)
            for axes, axis in zip(grid[line], AXES):
                rows = axis.rows(measured["rows"])
                sizes = [row["size"] for row in rows]
                axes.set(xscale="log", yscale="log", xlabel=f"{axis.name} ({axis.besides})" if line else "")
                axes.plot(sizes, [row[cost] * scale for row in rows], color=COLOURS[1], marker="o", markerfacecolor="white")
                if cost == "memory_bytes":
                    records = [record_bytes(row) * scale for row in rows]
                    axes.plot(sizes, records, color=GREY, linestyle=":", label="the record itself")
                    axes.legend(frameon=False, fontsize=9)
    return figure


def measured(options: argparse.Namespace) -> Measured:
    """All rows."""
    return {"rows": measure(axes_of(SMALL_SAMPLES) if options.small else AXES, options.small)}


BENCH = Bench("large_records", "time and memory of a record's lines", measured, section, draw)
