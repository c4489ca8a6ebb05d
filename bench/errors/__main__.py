"""Random scenes of every class: are tolerances kept, errors below their bounds and estimates, and how many modes and seconds do they take?

`PYTHONPATH=bench python -m errors [--draws 2] [--beside PROGRAM]` draws scenes of the paper's beam, which are held against an
independent sum of many more modes (`tests/scenes/tails.py`), and of beams of pieces, which are held against a far finer tolerance
(`tests/scenes/piece_tails.py`). Another build of the program beside it shows what a change costs. BEAMWAVE_SEED sets the seed.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from itertools import product
from pathlib import Path
from typing import Any, Iterator, NamedTuple

import numpy as np
import piece_tails
import tails
from common.measuring import run_scene
from workplace import Workplace, group_text

from . import PROGRAM, SEED

LEAST, MOST = 1e-5, 1000  # tolerance and samples of the paper's beam: the independent sum takes a second


class Judged(NamedTuple):
    """One run: estimates over errors are 0 where an error is above its bound, infinite where it is not above rounding."""

    kind: str
    groups: list
    modes: dict
    missed: float  # the largest error over what the tolerance allows
    estimates: tuple  # over errors, of displacement and velocity at each point


def judged(here: Workplace, draws: int) -> Iterator[Judged | None]:
    """All runs; None where one is refused, ends without trust or takes too long."""
    for number, kind, record in product(range(draws), tails.KINDS, tails.RECORDS):
        for _, scene, *ways in tails.scenes(SEED, kind, record, [number], LEAST, MOST):
            for modes in ways:
                found = tails.compare(here, scene, modes)
                yield found and Judged(kind, list(scene.groups.items()), modes, found[1], found[2:])
    for kind, _, _, groups, modes, finer in piece_tails.runs(draws, piece_tails.KINDS, tails.RECORDS, MOST, SEED):
        found = piece_tails.compare(here, groups, modes, finer)
        yield found and Judged(kind, groups, modes, found[1], found[2:])


def cost(program: Path, run: Judged) -> np.ndarray:
    """Modes and CPU seconds of a build."""
    from netCDF4 import Dataset

    os.environ["BEAMWAVE"] = str(program)
    text = "".join(group_text(*group) for group in [*run.groups, ("modes", run.modes)])
    with tempfile.TemporaryDirectory() as directory:
        took = run_scene(Path(directory), text)
        with Dataset(Path(directory) / "scene.nc") as result:
            return np.array([int(result["mode_count"][...]), took.seconds])


def table(rows: list[tuple[Judged, Any]]) -> Iterator[str]:
    """A line for each class."""
    yield "| class | runs | largest error over the tolerance | estimate over error: displacement | velocity | modes, CPU beside |"
    yield "|---|---|---|---|---|---|"
    for kind in [*dict.fromkeys(run.kind for run, _ in rows), "all"]:
        some = [row for row in rows if kind in (row[0].kind, "all")]
        cells = [kind, f"{len(some)}", f"{max(run.missed for run, _ in some):.2f}"]
        for i in (0, 1):
            values = np.concatenate([run.estimates[i] for run, _ in some])
            values = values[np.isfinite(values)]
            cells.append(f"{values.min():.2f}, median {np.median(values):.1f}" if len(values) else "–")
        ratios = [ratio for _, ratio in some if ratio is not None]
        cells.append("median {:.2f}, {:.2f}".format(*np.median(ratios, axis=0)) if ratios else "–")
        yield f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=2, help="scenes of each class with each kind of record")
    parser.add_argument("--beamwave", type=Path, default=PROGRAM)
    parser.add_argument("--beside", type=Path, help="another build of the program")
    options = parser.parse_args()
    program, beside = options.beamwave.resolve(), options.beside and options.beside.resolve()
    rows, refused = [], 0
    with tempfile.TemporaryDirectory() as directory:
        for run in judged(Workplace(program, Path(directory)), options.draws):
            if run is None:
                refused += 1
                continue
            compared = beside and "tolerance" in run.modes
            rows.append((run, cost(program, run) / cost(beside, run) if compared else None))
            if run.missed > 1 or min(np.min(estimate) for estimate in run.estimates) < 1:
                print(run, file=sys.stderr, flush=True)
    print("\n".join(table(rows)))
    print(f"{refused} runs were refused, ended without trust or took too long.")


if __name__ == "__main__":
    main()
