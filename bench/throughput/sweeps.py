"""What else is asked of sweeps: two processes beside one, memory against the number of cases, and whether `beamwave check`
says beforehand what a run takes."""

from __future__ import annotations

import os
import re
import shutil
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

from common.command import BENCH, PROJECT

from .jobs import JOBS, Job

Row = dict[str, Any]
LAUNCH = BENCH / "growth/launch.py"
ROUNDS = 3
RANKS = Job("ranks", "histories of 4096 samples at two points, 40 modes", modes=40, cases=10_000, samples=4096)
TINY = Job("tiny", "one mode", modes=1, cases=0)
CASES = [1_000, 10_000, 100_000]
SCENES = ["input/critical_speed.nml", "input/spectrum.nml", "input/paper/fig5.nml", "input/paper/fig7.nml"]
MPI = {  # what Open MPI has to be told, and others do not mind
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
}


def launched(*words: Any) -> tuple[float, float, float]:
    """CPU seconds, wall seconds and peak bytes of a command."""
    command = [sys.executable, LAUNCH, *map(str, words)]
    said = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, **MPI}).stdout
    cpu, wall, peak = map(float, said.splitlines()[-1].split())
    return cpu, wall, peak


def run_words(directory: Path, job: Job, cases: int) -> list[Any]:
    scene = directory / f"{job.name}.nml"
    scene.write_text(job.scene(cases))
    return ["run", scene, "--output", directory, "--overwrite", "--quiet"]


def ranks(program: Path, directory: Path, small: bool) -> list[Row]:
    """One and two processes of the twin, in turns; start-up is what 20 cases take."""
    twin = program.with_name("beamwave-mpi")
    if not twin.exists() or shutil.which("mpirun") is None:
        return []
    cases = 100 if small else RANKS.cases
    seconds: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for _ in range(1 if small else ROUNDS):
        for count in (20, cases):
            for number in (1, 2):
                cpu, wall, _ = launched("mpirun", "-n", number, twin, *run_words(directory, RANKS, count))
                seconds.setdefault((number, count), []).append((wall, cpu))
    rows = []
    for number in (1, 2):
        wall, cpu = ([statistics.median(times[i] for times in seconds[number, count]) for count in (20, cases)] for i in (0, 1))
        rows.append({"ranks": number, "cases": cases, "start_wall": wall[0], "wall": wall[1] - wall[0], "cpu": cpu[1] - cpu[0]})
    return [rounded(row) for row in rows]


def memory(program: Path, directory: Path, small: bool) -> list[Row]:
    """Peaks of sweeps of very small cases."""
    rows = []
    for cases in CASES[: 1 if small else None]:
        cpu, _, peak = launched(program, *run_words(directory, TINY, cases))
        rows.append(rounded({"cases": cases, "cpu": cpu, "peak_mb": peak / 1e6}))
    return rows


def predictions(program: Path, directory: Path, small: bool) -> list[Row]:
    """What `check` says of the wall time, and the run's wall and CPU seconds."""
    scenes = [PROJECT / name for name in SCENES if (PROJECT / name).exists()]
    for job in JOBS:
        path = directory / f"{job.name}.nml"
        path.write_text(job.scene(100 if small else job.cases))
        scenes.append(path)
    rows = []
    for scene in scenes:
        pairs = []
        for _ in range(1 if small else ROUNDS):
            said = subprocess.run([program, "check", scene], check=True, capture_output=True, text=True).stdout
            expected = seconds_of(re.search(r"^ *time +about ([\d.]+) (\w+)", said, re.MULTILINE))
            cpu, wall, _ = launched(program, "run", scene, "--output", directory, "--overwrite", "--quiet")
            pairs.append((expected, wall, cpu))
        expected, wall, cpu = (statistics.median(pair[i] for pair in pairs) for i in range(3))
        rows.append(rounded({"scene": scene.stem, "expected": expected, "wall": wall, "cpu": cpu}))
    return rows


def seconds_of(said: re.Match[str] | None) -> float:
    assert said, "check says no time"
    return float(said[1]) * {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}[said[2]]


def rounded(row: Row) -> Row:
    return {name: float(f"{value:.3g}") if isinstance(value, float) else value for name, value in row.items()}
