"""What else is asked of sweeps: two processes beside one, memory against the number of cases, whether `beamwave check` says
beforehand what a run takes; and what many small scenes cost in one call."""

from __future__ import annotations

import os
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import netCDF4

from common.command import BENCH, PROJECT

from .jobs import JOBS, Job

Row = dict[str, Any]
LAUNCH = BENCH / "growth/launch.py"
ROUNDS = 3
RANKS = [  # with little, more and much work for each number that a case has
    Job("ranks", "frequencies and wave velocities of 20 modes", modes=20, cases=100_000),
    Job("ranks", "histories of 4096 samples at two points, 40 modes", modes=40, cases=10_000, samples=4096),
    Job("ranks", "the same of a beam that tension stiffens", modes=40, cases=600, samples=4096, more="&stiffening /\n"),
]
TINY = Job("tiny", "one mode", modes=1, cases=0)
CASES = [1_000, 10_000, 100_000]
SCENES = [  # of every kind: modes alone, a history, a spectrum, sweeps, modes without a closed form, later events
    "input/paper/fig5.nml",
    "input/paper/fig7.nml",
    "input/moving_beam.nml",
    "input/spectrum.nml",
    "input/critical_speed.nml",
    *(f"input/effects/{name}.nml" for name in ("damping", "stiffening", "shear", "body_inertia", "release", "recontact")),
]
SMALL_SCENES = 200
SMALL = """&beam length = 1.0, diameter = 0.037, density = 7870.0, youngs_modulus = 2e11 /
&rotation angular_velocity = {speed} /
&impact mass_ratio = 0.2 /
&capture /
&modes before = 20, after = 20 /
"""
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
    """To run a sweep anew: a result that is there would be nothing to do."""
    scene = directory / f"{job.name}.nml"
    scene.write_text(job.scene(cases))
    (directory / f"{job.name}.nc").unlink(missing_ok=True)
    return ["run", scene, "--output", directory, "--quiet"]


def ranks(program: Path, directory: Path, small: bool) -> list[Row]:
    """One and two processes of the twin, and two parts without MPI, in turns; start-up is what 20 cases take."""
    twin = program.with_name("beamwave-mpi")
    if not twin.exists() or shutil.which("mpirun") is None:
        return []
    shares = {
        "1 process of `beamwave-mpi`": ["mpirun", "-n", 1, twin],
        "2 processes of `beamwave-mpi`": ["mpirun", "-n", 2, twin],
        "1 process": [program],
        "2 parts": ["sh", "-c", PARTS, program],
    }
    return [row for job in RANKS for row in ranks_of(job, shares, directory, small)]


PARTS = '"$0" "$@" --part 1/2 & one=$!; "$0" "$@" --part 2/2 && wait $one'


def ranks_of(job: Job, shares: dict[str, list[Any]], directory: Path, small: bool) -> list[Row]:
    cases = 100 if small else job.cases
    seconds: dict[tuple[str, int], list[tuple[float, float]]] = {}
    for _ in range(1 if small else ROUNDS):
        for count in (20, cases):
            for by, words in shares.items():
                cpu, wall, _ = launched(*words, *run_words(directory, job, count))
                seconds.setdefault((by, count), []).append((wall, cpu))
    rows = []
    for by in shares:
        wall, cpu = ([statistics.median(times[i] for times in seconds[by, count]) for count in (20, cases)] for i in (0, 1))
        row = {"what": job.what, "by": by, "cases": cases, "start_wall": wall[0], "wall": wall[1] - wall[0]}
        rows.append({**row, "cpu": cpu[1] - cpu[0]})
    return [rounded(row) for row in rows]


def memory(program: Path, directory: Path, small: bool) -> list[Row]:
    """Peaks of sweeps of very small cases."""
    rows = []
    for cases in CASES[: 1 if small else None]:
        cpu, _, peak = launched(program, *run_words(directory, TINY, cases))
        rows.append(rounded({"cases": cases, "cpu": cpu, "peak_mb": peak / 1e6}))
    return rows


def predictions(program: Path, directory: Path, small: bool) -> list[Row]:
    """What `check` says of wall time, memory and file, and what the run takes; and a run's CPU seconds."""
    scenes = [PROJECT / name for name in SCENES[: 2 if small else None]]
    for job, cases in [*((job, job.cases) for job in JOBS), (TINY, CASES[-1])]:
        path = directory / f"{job.name}.nml"
        path.write_text(job.scene(100 if small else cases))
        scenes.append(path)
    rows = []
    for scene in scenes:
        runs = []
        for _ in range(1 if small else ROUNDS):
            said = subprocess.run([program, "check", scene], check=True, capture_output=True, text=True).stdout
            cpu, wall, peak = launched(program, "run", scene, "--output", directory, "--overwrite", "--quiet")
            result = directory / f"{scene.stem}.nc"
            said_of = [said_in(name, said) for name in ("time", "memory", "result")]
            runs.append((*said_of, wall, cpu, peak, result.stat().st_size))
            result.unlink()
        expected, said_peak, said_size, wall, cpu, peak, size = (statistics.median(run[i] for run in runs) for i in range(7))
        row = {"scene": scene.stem, "expected": expected, "wall": wall, "cpu": cpu}
        rows.append(rounded({**row, "memory_ratio": said_peak / peak, "size_ratio": said_size / size}))
    return rows


def scenes(program: Path, directory: Path, small: bool) -> list[Row]:
    """CPU milliseconds per scene: many small scenes in one call, one in a call, and a file as theirs by netCDF4 alone."""
    count = 10 if small else SMALL_SCENES
    work = directory / "scenes"
    work.mkdir()
    for number in range(count):
        (work / f"s{number:04d}.nml").write_text(SMALL.format(speed=0.1 * number))
    times: dict[str, list[float]] = {}
    for turn in range(1 if small else ROUNDS):
        output, alone = directory / f"out{turn}", directory / f"alone{turn}"
        in_one = launched(program, "run", work, "--output", output, "--quiet")[0] / count
        times.setdefault("in one call of all", []).append(in_one)
        in_its_own = launched(program, "run", work / "s0000.nml", "--output", alone, "--quiet")[0]
        times.setdefault("in a call of its own", []).append(in_its_own)
        times.setdefault("`beamwave --version`", []).append(launched(program, "--version")[0])
        written = rewritten(output / "s0000.nc", directory / "copy.nc", count)
        times.setdefault("to write its file alone, in Python with netCDF4", []).append(written)
    return [{"what": what, "ms": float(f"{1e3 * statistics.median(values):.3g}")} for what, values in times.items()]


def rewritten(model: Path, path: Path, count: int) -> float:
    """CPU seconds to write a file with the names, attributes and values of another."""
    with netCDF4.Dataset(model) as file:
        file.set_auto_mask(False)
        about = {name: file.getncattr(name) for name in file.ncattrs()}
        dimensions = {name: len(dimension) for name, dimension in file.dimensions.items()}
        variables = [(v.name, v.dtype, v.dimensions, v.__dict__, v[...]) for v in file.variables.values()]
    before = time.process_time()
    for _ in range(count):
        with netCDF4.Dataset(path, "w") as file:
            file.setncatts(about)
            for name, length in dimensions.items():
                file.createDimension(name, length)
            made = []
            for name, kind, over, attributes, _ in variables:
                variable = file.createVariable(name, kind, over, fill_value=attributes.get("_FillValue"))
                variable.setncatts({n: value for n, value in attributes.items() if n != "_FillValue"})
                made.append(variable)
            for variable, (*_, values) in zip(made, variables):
                variable[...] = values
    return (time.process_time() - before) / count


UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "kB": 1e3, "MB": 1e6, "GB": 1e9}


def said_in(name: str, text: str) -> float:
    """The number of a line of `check`, in s or bytes."""
    said = re.search(rf"^ *{name} +(?:about )?([\d.]+) (\w+)", text, re.MULTILINE)
    assert said, f"check says no {name}"
    return float(said[1]) * UNITS[said[2]]


def rounded(row: Row) -> Row:
    return {name: float(f"{value:.3g}") if isinstance(value, float) else value for name, value in row.items()}
