"""Time and memory of the lines of a record against its samples and sensors."""

from __future__ import annotations

from operator import itemgetter
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from common import growing
from common.bench import Bench, Measured
from common.growing import Axis, megabytes

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
    """Text and tables."""
    memory = {"memory MB": megabytes(itemgetter("memory_bytes")), "record MB": megabytes(record_bytes)}
    sizes = {"wall s": lambda row: f"{row['wall_seconds']:.3g}", **memory}
    return growing.section(measured, WORDS.format(lines=LINES), AXES, {}, sizes)


BENCH = Bench(
    "large_records",
    "time and memory of a record's lines",
    lambda options: {"rows": growing.measure(axes_of(SMALL_SAMPLES) if options.small else AXES, options.small)},
    section,
    lambda measured: growing.draw(
        measured["rows"], [(f"{axis.name} ({axis.besides})", {axis.name: ""}) for axis in AXES], record_bytes, "the record itself"
    ),
)
