"""Instructions, counted by valgrind, and seconds of the stages as the result holds them."""

from __future__ import annotations

import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from .scenes import SMALL_VARIANTS, VARIANTS, Variant

ROUNDS = 11


def measure(program: Path, small: bool) -> list[dict[str, Any]]:
    """One row for each scene. Times are interleaved: round by round each scene is run once."""
    portable = Path(os.environ.get("BEAMWAVE_PORTABLE", program))
    variants = SMALL_VARIANTS if small else VARIANTS
    start = instructions(portable, "--version")
    rounds = [[run(program, variant, small) for variant in variants] for _ in range(1 if small else ROUNDS)]
    return [row(portable, variant, list(runs), start, small) for variant, runs in zip(variants, zip(*rounds))]


def row(
    program: Path, variant: Variant, runs: list[tuple[float, str]], start: int | None, small: bool
) -> dict[str, Any]:
    """Numbers of one scene."""
    counted = None if start is None else count(program, variant, small)
    seconds = statistics.median(seconds for seconds, _ in runs)
    print(f"  {variant.words}: {seconds:.3g} s", file=sys.stderr, flush=True)
    return {
        "variant": variant.words,
        "beside": variant.beside,
        "method": runs[0][1],
        "instructions": None if counted is None or start is None else counted - start,
        "seconds": float(f"{seconds:.3g}"),
        "runs": len(runs),
    }


def run(program: Path, variant: Variant, small: bool) -> tuple[float, str]:
    """Seconds of all stages but writing, and the method."""
    from netCDF4 import Dataset

    with tempfile.TemporaryDirectory() as directory:
        words = command(program, variant, small, Path(directory))
        ended = subprocess.run(words, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise RuntimeError(f"{variant.words}: beamwave ended with {ended.returncode}\n{ended.stderr}")
        with Dataset(Path(directory) / "scene.nc") as result:
            stages = result["stage"].flag_meanings.split()
            return float(sum(t for t, name in zip(result["stage_seconds"][:], stages) if name != "write")), result.method


def count(program: Path, variant: Variant, small: bool) -> int | None:
    """Instructions of a run."""
    with tempfile.TemporaryDirectory() as directory:
        return instructions(*command(program, variant, small, Path(directory)))


def command(program: Path, variant: Variant, small: bool, directory: Path) -> list[str | Path]:
    """A scene in a directory, and the words that run it there."""
    scene = directory / "scene.nml"
    scene.write_text(variant.scene(small))
    return [program, "run", scene, "--output", directory, "--quiet"]


def instructions(*words: str | Path) -> int | None:
    """Instructions of a command; None without valgrind, or where it does not know the processor's."""
    if not shutil.which("valgrind"):
        return None
    counting = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    ended = subprocess.run([*counting, *words], capture_output=True, text=True, check=False)
    found = re.search(r"Collected : (\d+)", ended.stderr)
    return int(found[1]) if found and ended.returncode == 0 else None
