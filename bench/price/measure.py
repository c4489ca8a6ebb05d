"""Runs `beamwave accuracy` on each scene and keeps its rungs."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import netCDF4
from common.command import PROJECT

SCENE = PROJECT / "input/spectrum.nml"
SAMPLES, SMALL = (65_536, 4096), (256,)
NUMBERS = {  # our name: the file's variable
    "tolerance": "tolerance",
    "modes": "mode_count",
    "error": "true_error",
    "estimate": "estimated_error",
    "repeats": "repeats",
    "seconds": "seconds",
    "lower": "seconds_lower",
    "upper": "seconds_upper",
    "digit_seconds": "digit_seconds",
    "digit_growth": "digit_growth",
    "digit_noise": "digit_noise",
}
WHOLE = ("modes", "repeats")


def measure(program: Path, small: bool) -> dict[str, Any]:
    """Rows of all scenes, and what each scene's errors were measured against."""
    rows: list[dict[str, Any]] = []
    against: dict[str, dict[str, float]] = {}
    for samples in SMALL if small else SAMPLES:
        print(f"  {SCENE.name} with {samples} samples", file=sys.stderr, flush=True)
        with tempfile.TemporaryDirectory() as directory:
            scene = Path(directory) / "price.nml"
            scene.write_text(re.sub(r"(samples *= *)\d+", rf"\g<1>{samples}", SCENE.read_text(encoding="utf-8")))
            words = [program, "accuracy", scene, "--output", directory, "--quiet"]
            subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
            with netCDF4.Dataset(Path(directory) / "price.accuracy.nc") as file:
                rows += [{"samples": samples, **row} for row in rungs(file)]
                against[str(samples)] = {name: rounded(file[name][()]) for name in ("converged_error",)}
    return {"against": against, "rows": rows}


def rungs(file: netCDF4.Dataset) -> list[dict[str, Any]]:
    """One row for each rung; what a rung has not is left out."""
    ladder, status, stages = file["ladder"], file["rung_status"], file["stage"].flag_meanings.split()
    rows = []
    for place in range(file.dimensions["rung"].size):
        row: dict[str, Any] = {"ladder": word(ladder, place), "status": word(status, place)}
        for name, variable in NUMBERS.items():
            value = file[variable][place]
            if value is not netCDF4.numpy.ma.masked:
                row[name] = int(value) if name in WHOLE else rounded(value)
        if "seconds" in row:
            row["stages"] = dict(zip(stages, map(rounded, file["stage_seconds"][place])))
        rows.append(row)
    return rows


def word(flags: netCDF4.Variable, place: int) -> str:
    """The word of a flag."""
    return flags.flag_meanings.split()[list(flags.flag_values).index(flags[place])]


def rounded(value: Any) -> float:
    """As many digits as a table shows, and one more."""
    return float(f"{float(value):.3g}")
