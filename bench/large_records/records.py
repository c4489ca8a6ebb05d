"""The records of the bench: decaying lines in white noise, of more and more samples or sensors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np

LINES = 20
RATE = 2048.0  # Hz
NOISE = 0.01  # of a typical amplitude
BLOCK = 2**16  # samples that are made at once
SEED = 5


@dataclass(frozen=True)
class RecordAxis:
    """What grows, samples or sensors, while the other stays; with the names that the bench of growth asks for."""

    name: str
    besides: str
    sizes: tuple[int, ...]
    small: tuple[int, ...]
    fixed: int  # samples where sensors grow, sensors where samples do

    def shape(self, size: int) -> tuple[int, int]:
        """Samples and sensors."""
        return (size, self.fixed) if self.name == "samples" else (self.fixed, size)

    def scene(self, _: int) -> str:
        """The scene, which is the same for all sizes."""
        return "&record\n  file = 'record.nc'\n/\n&spectrum /\n"

    def prepare(self, directory: Path, size: int) -> None:
        """Write the record beside the scene."""
        write(directory / "record.nc", *self.shape(size))


AXES = (
    RecordAxis("samples", "64 sensors", (2**14, 2**16, 2**18, 2**20), (4096, 16384), 64),
    RecordAxis("sensors", "1 048 576 samples", (1, 4, 16, 64), (1, 2), 2**20),
)


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
