"""Measure round by round, each way once a round; medians of CPU seconds per case go into a table."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import netCDF4
import numpy as np

from common.command import PROJECT
from common.document import put_section
from common.machine import describe
from overview import put_overview

from . import sweeps
from .designs import designs
from .jobs import JOBS, Job
from .section import FIRST, WAYS, section
from .with_numpy import case, loop, pooled, save

DATA = Path(__file__).with_name("measured.json")
MEMORY = "/dev/shm" if Path("/dev/shm").is_dir() else None  # no disk is measured
ROUNDS, NUMPY_PART = 9, 10  # numpy does a part of the cases, spread over all of them
PARTS = ["rows", "designs", "ranks", "memory", "predictions", "scenes"]
AGREEMENT = 1e-7  # of the largest value: Gauss's rule and Newton's method in numpy


def cpu(work: Callable[[], Any]) -> float:
    """CPU seconds of this process and of those that it started and that have ended."""
    before = used()
    work()
    return used() - before


def used() -> float:
    """CPU seconds so far, to the microsecond."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def beamwave(program: Path, job: Job, cases: int, directory: Path) -> float:
    scene = directory / f"{job.name}.nml"
    scene.write_text(job.scene(cases))
    words = [program, "run", scene, "--output", directory, "--quiet"]
    for old in directory.glob("*.nc"):
        old.unlink()
    return cpu(lambda: subprocess.run(words, check=True, stderr=subprocess.DEVNULL)) / cases


def one_by_one(job: Job, grid: list[tuple[float, float]], directory: Path, by_products: bool = False) -> float:
    return cpu(lambda: save(loop(job, grid, by_products), directory / "numpy.nc")) / len(grid)


def pool(job: Job, grid: list[tuple[float, float]], directory: Path) -> float:
    work = [(job, place) for place in grid]

    def everything() -> None:
        workers = multiprocessing.Pool(2)
        save(workers.map(pooled, work, chunksize=max(1, len(work) // 20)), directory / "pool.nc")
        workers.close()
        workers.join()

    return cpu(everything) / len(grid)


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


def measure(program: Path, small: bool) -> list[dict[str, Any]]:
    rows = []
    for job in JOBS:
        cases = 100 if small else job.cases
        part = job.grid(cases)[:: 1 if small else NUMPY_PART]
        seconds: dict[str, list[float]] = {way: [] for way in WAYS}
        with tempfile.TemporaryDirectory(dir=MEMORY) as name:
            directory = Path(name)
            for turn in range(1 if small else ROUNDS):
                seconds["beamwave"].append(beamwave(program, job, cases, directory))
                if turn == 0:
                    worst = check(job, cases, directory)
                seconds["numpy loop"].append(one_by_one(job, part, directory))
                seconds["by products"].append(one_by_one(job, part, directory, by_products=True))
                seconds["pool of 2"].append(pool(job, part, directory))
        medians = {way: float(f"{statistics.median(values):.3g}") for way, values in seconds.items()}
        rows.append({"job": job.name, "what": job.what, "cases": cases, "difference": float(f"{worst:.1e}"), **medians})
    return rows


def main() -> None:
    words = argparse.ArgumentParser(prog="bench/throughput.sh", description=__doc__)
    words.add_argument("--small", action="store_true", help="few cases: does everything run?")
    words.add_argument("--redraw", action="store_true", help="the section of the data that is there")
    words.add_argument("--only", choices=PARTS, help="measure one part; keep the others")
    words.add_argument("--beamwave", type=Path, default=PROJECT / "build/bin/beamwave", help="the program")
    given = words.parse_args()
    program = given.beamwave.resolve()
    measured = json.loads(DATA.read_text(encoding="utf-8"))
    if not given.redraw:
        parts = [given.only] if given.only else PARTS
        about = {**describe(program, ("numpy",)), "date": time.strftime("%Y-%m-%d")}
        for part in parts:
            measured[part] = {"about": about, "rows": part_of(part, program, given.small)}
    if given.small:
        print(section(measured))
        return
    DATA.write_text(json.dumps(measured, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    put_section(PROJECT / "docs/numbers.md", FIRST, section(measured))
    put_overview()
    print(section(measured))


def part_of(part: str, program: Path, small: bool) -> list[dict[str, Any]]:
    """Measure one part."""
    if part == "rows":
        return measure(program, small)
    measures = designs if part == "designs" else getattr(sweeps, part)
    with tempfile.TemporaryDirectory(dir=MEMORY) as name:
        return measures(program, Path(name), small)


if __name__ == "__main__":
    main()
