"""Time and memory of `beamwave run` along each axis, interleaved: round by round each scene is run once."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Protocol, Sequence

LAUNCH = Path(__file__).with_name("launch.py")
ROUNDS = 5
LONG, LONG_ROUNDS = 5.0, 1  # what takes longer than this, s, is run so many times


class Growing(Protocol):
    """What grows: its sizes, and the scene of each with what must lie beside it."""

    name: str
    sizes: tuple[int, ...]
    small: tuple[int, ...]

    def scene(self, size: int) -> str: ...

    def prepare(self, directory: Path, size: int) -> None: ...


Job = tuple[Growing, int]


def measure(program: Path, axes: Sequence[Growing], small: bool) -> list[dict[str, Any]]:
    """One row for each axis and size."""
    jobs: list[Job] = [(axis, size) for axis in axes for size in (axis.small if small else axis.sizes)]
    runs: list[list[tuple[float, float, int, int]]] = [[] for _ in jobs]
    rounds = 1 if small else ROUNDS
    for turn in range(rounds):
        for job, kept in zip(jobs, runs):
            wanted = LONG_ROUNDS if kept and kept[0][0] > LONG else rounds
            if turn < wanted:
                kept.append(run(program, job))
                if turn == 0:
                    print(f"  {job[0].name} {job[1]}: {kept[0][0]:.3g} s", file=sys.stderr, flush=True)
    return [row(job, kept) for job, kept in zip(jobs, runs)]


def run(program: Path, job: Job) -> tuple[float, float, int, int]:
    """CPU seconds, wall seconds, peak memory and the result's size in bytes."""
    axis, size = job
    with tempfile.TemporaryDirectory() as directory:
        scene = Path(directory) / "growth.nml"
        scene.write_text(axis.scene(size))
        axis.prepare(Path(directory), size)
        words = [sys.executable, "-I", "-S", LAUNCH, program, "run", scene, "--output", directory, "--quiet"]
        ended = subprocess.run(words, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise RuntimeError(f"{axis.name} {size}: beamwave ended with {ended.returncode}\n{ended.stderr}")
        processor, wall, memory = ended.stdout.split()
        return float(processor), float(wall), int(memory), (Path(directory) / "growth.nc").stat().st_size


def row(job: Job, runs: list[tuple[float, float, int, int]]) -> dict[str, Any]:
    """Medians of times, the largest memory."""
    processor, wall, memory, result = zip(*runs)
    return {
        "axis": job[0].name,
        "size": job[1],
        "cpu_seconds": float(f"{statistics.median(processor):.3g}"),
        "wall_seconds": float(f"{statistics.median(wall):.3g}"),
        "memory_bytes": max(memory),
        "result_bytes": max(result),
        "runs": len(runs),
    }
