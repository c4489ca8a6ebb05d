"""The parts of the bench: cases per second beside numpy, a design beside a sweep, two processes beside one, memory against the
number of cases, whether `beamwave check` says beforehand what a run takes, and what many small scenes cost in one call."""

from __future__ import annotations

import os
import re
import resource
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import netCDF4
import numpy as np
from common.bench import PROJECT, Rows
from common.measuring import expected, in_turns, launched, median, rounded
from workplace import MPI_ON_FEW_CORES

from .jobs import JOBS, Job
from .with_numpy import case, loop, save

WAYS = ["beamwave", "numpy loop", "by products"]
ROUNDS, ROUNDS_OF_DESIGNS, ROUNDS_OF_RUNS = 9, 15, 3
NUMPY_PART = 10  # numpy does a part of the cases, spread over all of them
AGREEMENT = 1e-7  # of the largest value: Gauss's rule and Newton's method in numpy
DESIGN_CASES = 10_000
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
MPI = {**MPI_ON_FEW_CORES, "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe", "OMPI_MCA_mpi_yield_when_idle": "1"}
TWO_PARTS = '"$0" "$@" --part 1/2 & one=$!; "$0" "$@" --part 2/2 && wait $one'


def rates(program: Path, directory: Path, small: bool) -> Rows:
    """CPU seconds per case of each way, with start-up."""
    rows = []
    for job in JOBS:
        cases = 100 if small else job.cases
        grid = job.grid(cases)[:: 1 if small else NUMPY_PART]
        ways: dict[str, tuple[Callable[[], Any], int]] = {
            "beamwave": (lambda: subprocess.run([program, *job.words(directory, cases)], check=True, stderr=subprocess.DEVNULL), cases),
            "numpy loop": (lambda: save(loop(job, grid), directory / "numpy.nc"), len(grid)),
            "by products": (lambda: save(loop(job, grid, by_products=True), directory / "numpy.nc"), len(grid)),
        }

        def run(way: str) -> tuple[float]:
            work, count = ways[way]
            return (cpu(work) / count,)

        answers = in_turns(WAYS, run, 1 if small else ROUNDS)
        medians = {way: median(seconds for (seconds,) in runs) for way, runs in zip(WAYS, answers)}
        difference = float(f"{check(job, cases, directory):.1e}")
        rows.append({"job": job.name, "what": job.what, "cases": cases, "difference": difference, **medians})
    return rows


def cpu(work: Callable[[], Any]) -> float:
    """CPU seconds of this process and of those that it started and that have ended."""
    before = used()
    work()
    return used() - before


def used() -> float:
    """CPU seconds so far, to the microsecond."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def check(job: Job, cases: int, directory: Path) -> float:
    """The largest difference between both over the largest value; the job is the same."""
    worst = 0.0
    with netCDF4.Dataset(directory / f"{job.name}.nc") as file:
        for index in np.linspace(0, cases - 1, 7).astype(int):
            speed, ratio = job.grid(cases)[index]
            for by_products in [False, True]:
                for name, values in case(job, speed, ratio, by_products).items():
                    there = np.asarray(file[name][index])
                    worst = max(worst, np.abs(there - values).max() / np.abs(there).max())
    assert worst < AGREEMENT, f"{job.name}: numpy and beamwave differ by {worst:.1e}"
    return worst


def designs(program: Path, directory: Path, small: bool) -> Rows:
    """CPU seconds of a design and of a sweep of the same cases, and the median of how much more the design takes in each turn."""
    rows = []
    cases = 100 if small else DESIGN_CASES
    for job in JOBS[:2]:

        def run(words: Callable[[Path, Job, int], list[Any]]) -> tuple:
            return launched(program, *words(directory, job, cases))

        sweeps, tables = in_turns([sweep_words, design_words], run, 1 if small else ROUNDS_OF_DESIGNS, lambda way: way.__name__)
        ratio = median(one[0] / other[0] for one, other in zip(tables, sweeps))  # of neighbours in time
        took = {"sweep": median(t[0] for t in sweeps), "design": median(t[0] for t in tables)}
        rows.append({"what": job.what, "cases": cases, **took, "ratio": ratio})
    return rows


def sweep_words(directory: Path, job: Job, cases: int) -> list[Any]:
    """The sweep itself."""
    return job.words(directory, cases)


def design_words(directory: Path, job: Job, cases: int) -> list[Any]:
    """The sweep's scene with a table of its cases."""
    words = job.words(directory, cases)
    scene = Path(words[1])
    text = re.sub(r"&sweep.*\n", "", scene.read_text()) + "&design file = 'cases.csv' /\n"
    scene.write_text(text)
    table = "".join(f"{float(ratio)!r},{float(speed)!r}\n" for speed, ratio in job.grid(cases))
    (directory / "cases.csv").write_text("impact%mass_ratio,rotation%angular_velocity\n" + table)
    return words


def ranks(program: Path, directory: Path, small: bool) -> Rows:
    """One and two processes of the twin, and two parts without MPI, in turns; start-up is what 20 cases take."""
    twin = program.with_name("beamwave-mpi")
    if not twin.exists() or shutil.which("mpirun") is None:
        return []
    os.environ.update(MPI)
    shares = {
        "1 process of `beamwave-mpi`": ["mpirun", "-n", 1, twin],
        "2 processes of `beamwave-mpi`": ["mpirun", "-n", 2, twin],
        "1 process": [program],
        "2 parts": ["sh", "-c", TWO_PARTS, program],
    }
    rows = []
    for job in RANKS:
        cases = 100 if small else job.cases
        runs = [(by, count) for count in (20, cases) for by in shares]

        def run(which: tuple[str, int]) -> tuple:
            return launched(*shares[which[0]], *job.words(directory, which[1]))

        answers = in_turns(runs, run, 1 if small else ROUNDS_OF_RUNS)
        medians = {which: [statistics.median(part) for part in list(zip(*took))[:2]] for which, took in zip(runs, answers)}
        for by in shares:
            (start, start_wall), (seconds, wall) = medians[by, 20], medians[by, cases]
            times = {"start_wall": start_wall, "wall": wall - start_wall, "cpu": seconds - start}
            rows.append({"what": job.what, "by": by, "cases": cases, **{name: rounded(time) for name, time in times.items()}})
    return rows


def memory(program: Path, directory: Path, small: bool) -> Rows:
    """Peaks of sweeps of very small cases."""
    rows = []
    for cases in CASES[: 1 if small else None]:
        took = launched(program, *TINY.words(directory, cases))
        rows.append({"cases": cases, "cpu": rounded(took.seconds), "peak_mb": rounded(took.memory / 1e6)})
    return rows


def predictions(program: Path, directory: Path, small: bool) -> Rows:
    """What `check` says of wall time, memory and file, and what the run takes; and a run's CPU seconds."""
    paths = [PROJECT / name for name in SCENES[: 2 if small else None]]
    for job, cases in [*((job, job.cases) for job in JOBS), (TINY, CASES[-1])]:
        paths.append(job.words(directory, 100 if small else cases)[1])

    def run(scene: Path) -> tuple[float, ...]:
        foretold = expected(program, scene)[:3]
        took = launched(program, "run", scene, "--output", directory, "--overwrite", "--quiet")
        result = directory / f"{scene.stem}.nc"
        size = result.stat().st_size
        result.unlink()
        return took.seconds, took.wall, took.memory, size, *foretold

    rows = []
    for scene, runs in zip(paths, in_turns(paths, run, 1 if small else ROUNDS_OF_RUNS, lambda path: path.stem)):
        seconds, wall, peak, size, said, said_peak, said_size = map(statistics.median, zip(*runs))
        numbers = {"expected": said, "wall": wall, "cpu": seconds, "memory_ratio": said_peak / peak, "size_ratio": said_size / size}
        rows.append({"scene": scene.stem, **{name: rounded(value) for name, value in numbers.items()}})
    return rows


def scenes(program: Path, directory: Path, small: bool) -> Rows:
    """CPU milliseconds per scene: many small scenes in one call, one in a call, and a file as theirs by netCDF4 alone."""
    count = 10 if small else SMALL_SCENES
    work = directory / "scenes"
    work.mkdir()
    for number in range(count):
        (work / f"s{number:04d}.nml").write_text(SMALL.format(speed=0.1 * number))

    def seconds_of(path: Path) -> float:
        output = tempfile.mkdtemp(dir=directory)
        return launched(program, "run", path, "--output", output, "--quiet").seconds

    launched(program, "run", work / "s0000.nml", "--output", directory, "--quiet")
    ways = {
        "in one call of all": lambda: seconds_of(work) / count,
        "in a call of its own": lambda: seconds_of(work / "s0000.nml"),
        "`beamwave --version`": lambda: launched(program, "--version").seconds,
        "to write its file alone, in Python with netCDF4": lambda: rewritten(directory / "s0000.nc", directory / "copy.nc", count),
    }
    answers = in_turns(list(ways), lambda way: (ways[way](),), 1 if small else ROUNDS_OF_RUNS)
    return [{"what": what, "ms": median(1e3 * seconds for (seconds,) in runs)} for what, runs in zip(ways, answers)]


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


PARTS = {part.__name__: part for part in (rates, designs, ranks, memory, predictions, scenes)}
