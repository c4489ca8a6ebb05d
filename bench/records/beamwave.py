"""The program itself: records in CSV files, many files to a scene, and the lines in its results."""

from __future__ import annotations

import os
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from .cells import Cell, Draw
from .tool import Lines, Tool

FILES = 500  # of a scene


def estimate(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
    """Every draw a case; the seconds are those of the whole process, with start-up, reading and writing."""
    found: list[Lines] = []
    seconds = 0.0
    for first in range(0, len(draws), FILES):
        with tempfile.TemporaryDirectory() as directory:
            seconds += run(Path(directory), draws[first : first + FILES])
            found += read(Path(directory) / "scene.nc")
    return found, seconds


def run(directory: Path, draws: list[Draw]) -> float:
    """Write records and scene, and run it: CPU seconds."""
    names = [f"'{number}.csv'" for number in range(len(draws))]
    for number, draw in enumerate(draws):
        columns = ",".join(f"s{sensor}" for sensor in range(draw.values.shape[1]))
        np.savetxt(
            directory / f"{number}.csv", np.column_stack([draw.times, draw.values]), "%.17g", ",", header=f"t,{columns}", comments=""
        )
    files = ",\n  ".join(names)
    (directory / "scene.nml").write_text(f"&record\n  file = {files}\n/\n&spectrum /\n")
    words = [os.environ["BEAMWAVE"], "run", directory / "scene.nml", "--output", directory, "--quiet"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    if ended.returncode not in (0, 4):
        raise RuntimeError(f"beamwave ended with {ended.returncode}\n{ended.stderr[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def read(result: Path) -> list[Lines]:
    """Lines of each case; a step is a second."""
    from netCDF4 import Dataset

    names = [f"measured_{what}{part}" for part in ("", "_error") for what in ("angular_frequency", "decay_rate")]
    with Dataset(result) as data:
        rows = [np.atleast_2d(np.ma.filled(data[name][:].astype(float), np.nan)) for name in names]
        counts = np.atleast_1d(np.ma.filled(data["peak_count"][:], 0))
    turns = 2 * np.pi
    return [
        Lines(rows[0][case, :count] / turns, rows[1][case, :count], rows[2][case, :count] / turns, rows[3][case, :count])
        for case, count in enumerate(counts)
    ]


TOOL = Tool("beamwave", "nothing", estimate, needs=("netCDF4",))
