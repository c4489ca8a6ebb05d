"""The coefficients of the cost model in src/case/bw_case_cost.f90, fitted to runs of random scenes, and how well they hold.

    cmake --build build --target bench_cost
    PYTHONPATH=bench OPENBLAS_NUM_THREADS=1 python -m cost [--beamwave PROGRAM] [--seed 1] [--draws 12] [--check]

Prints the seconds of the source's terms in their order, fitted to the relative error of the CPU seconds of whole runs. With
--check nothing is fitted: it prints how far seconds and memory that `beamwave check` says are from those of the runs, the worst first.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from common.bench import PROGRAM
from common.measuring import expected, launched

from .scenes import drawn

LEAST = 0.02  # s, from which a factor of 3 is promised
FACTOR = 3
PATIENCE = 60  # s of a run; what takes longer is left out


class Run(NamedTuple):
    name: str
    seconds: float  # of processor time
    memory: float  # bytes
    said_seconds: float
    said_memory: float
    check_seconds: float
    counts: np.ndarray


def runs(program: Path, seed: int, draws: int, directory: Path) -> list[Run]:
    """Of all scenes: the better of two runs beside what was said before it."""
    found = []
    for name, text in drawn(seed, draws):
        scene = directory / f"{name}.nml"
        scene.write_text(text)
        try:
            counted = launched(program.with_name("bench_cost"), scene).said.split()
            _, memory, _, check = expected(program, scene)
            took = []
            for turn in "ab":  # a result that is there would be nothing to do
                words = [program, "run", scene, "--output", directory / turn, "--quiet", "--max-seconds", PATIENCE]
                took.append(launched(*words, accepted=(0, 4)))
        except RuntimeError:
            continue  # refused, or not done in time
        seconds, *counts = map(float, counted[1:])
        best = min(took)
        found.append(Run(name, best.seconds, best.memory, seconds, memory, check, np.array(counts)))
    return found


def fitted(found: list[Run]) -> np.ndarray:
    """Seconds of the terms, none below 0: the least relative deviations, too much and too little weighing alike."""
    counts = np.array([run.counts for run in found])
    seconds = np.array([run.seconds for run in found])
    said = seconds
    for _ in range(30):
        weight = 1 / np.sqrt(said * seconds)
        terms, _ = nnls(counts * weight[:, None], seconds * weight)
        said = np.maximum(counts @ terms, 1e-4)
    return terms


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m cost", description=__doc__.splitlines()[0])
    parser.add_argument("--beamwave", type=Path, default=PROGRAM, help="the program, bench_cost beside it")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--draws", type=int, default=12, help="scenes of each kind")
    parser.add_argument("--check", action="store_true", help="judge the built program's own coefficients")
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        found = runs(words.beamwave.resolve(), words.seed, words.draws, Path(directory))
    terms = None if words.check else fitted(found)
    if terms is not None:
        print(*(f"{seconds:.1e}" for seconds in terms), sep="\n")
    ratio = {run.name: (run.said_seconds if terms is None else run.counts @ terms) / run.seconds for run in found}
    long = [run for run in found if run.seconds > LEAST]
    outside = sorted((run for run in long if not 1 / FACTOR <= ratio[run.name] <= FACTOR), key=lambda run: ratio[run.name])
    print(f"{len(found)} runs, {len(long)} of them above {LEAST} s: {len(outside)} outside a factor of {FACTOR}")
    for run in outside:
        print(f"  {run.name}: {run.seconds:.3f} s, expected {ratio[run.name]:.2g} times that")
    for run in found:
        if run.said_memory < run.memory:
            print(f"  {run.name}: {run.memory / 1e6:.0f} MB, expected {run.said_memory / run.memory:.2f} times that")
    slow = [run.check_seconds for run in found]
    few, most = np.quantile(slow, [0.5, 0.9])
    print(f"check took {few:.3f} s in the median, {most:.3f} s in nine of ten, {max(slow):.2f} s at most")
    return 0


if __name__ == "__main__":
    sys.exit(main())
