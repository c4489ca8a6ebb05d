"""Random scenes of every class: are tolerances kept, errors below their bounds and estimates, and how many modes and seconds do they take?

`PYTHONPATH=bench python -m errors [--draws 2] [--beside PROGRAM]` draws scenes of the paper's beam, which are held against
an independent sum of many more modes (`tests/scenes/tails.py`), and of beams of pieces, which are held against a far finer tolerance
(`tests/scenes/piece_tails.py`). Another build of the program beside it shows what a change costs. BEAMWAVE_SEED sets the seed.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Iterator, NamedTuple

import numpy as np
import piece_tails
import tails
from workplace import Workplace, group_text

from . import PROGRAM, SEED

PATIENCE = 120  # seconds for a run; a scene that takes longer is left out
LEAST, MOST = 1e-5, 1000  # tolerance and samples of the paper's beam: the independent sum takes a second
PIECES_ROUNDING = 2e-13  # of a comparison with the program itself, over the peak
FIELDS = ["displacement", "velocity"]


class Drawn(NamedTuple):
    kind: str
    groups: list
    modes: dict
    scene: Any  # of the paper's beam; None of pieces


class Judged(NamedTuple):
    """Of one run: what may be above 1, and ratios of points whose error is above rounding."""

    kind: str
    missed: float  # the largest error over what the tolerance allows
    bound: np.ndarray  # over the error
    estimate: list  # over the error, of displacement and velocity, where that is under a tenth of the motion
    cost: tuple  # modes and CPU seconds
    beside: tuple | None


def drawn(draws: int) -> Iterator[Drawn]:
    for number in range(draws):
        for kind in tails.KINDS:
            for record in tails.RECORDS:
                for _, scene, *ways in tails.scenes(SEED, kind, record, [number], LEAST, MOST):
                    for modes in ways:
                        yield Drawn(kind, list(scene.groups.items()), modes, scene)
        for kind in piece_tails.KINDS:
            for record in tails.RECORDS:
                rng = np.random.default_rng([SEED, piece_tails.KINDS.index(kind), tails.RECORDS.index(record), number])
                groups = piece_tails.draw(rng, kind, record, MOST)
                tolerance = tails.log_between(rng, 1e-6 if kind == "shear" else 1e-7, 1e-2)
                counts = {name: int(tails.log_between(rng, 2, 100)) for name in ("before", "after")}
                for modes in ({"tolerance": tolerance}, counts):
                    yield Drawn(kind, groups, modes, None)


def run(program: Path, drawing: Drawn, modes: dict) -> tuple[Any, float] | None:
    """The result and CPU seconds; None where it is refused or takes too long."""
    with tempfile.TemporaryDirectory() as directory:
        here = Workplace(program, Path(directory))
        here.write("a.nml", "".join(group_text(*group) for group in [*drawing.groups, ("modes", modes)]))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            ended = here.beamwave("run", "a.nml", "--quiet", timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return None
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if ended.returncode:
            return None
        return here.result("a"), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def errors_of(program: Path, drawing: Drawn, result: Any) -> tuple[list, list] | None:
    """Errors above rounding and largest motions of displacement and velocity at each point."""
    modes, used = drawing.modes, int(result["mode_count"])
    if drawing.scene is not None:
        if "before" in modes:
            used = max(modes.values()) if drawing.scene.motion.release is not None else modes["after"]
        values, rounding, own = tails.truths(drawing.scene, used), 10 * tails.ROUNDING, 0.0
    else:
        finer = max(modes["tolerance"] / 300, 1e-7 if drawing.kind == "shear" else 1e-9) if "tolerance" in modes else 1e-6
        finest = run(program, drawing, {"tolerance": finer})
        if finest is None:
            return None
        values, rounding, own = [finest[0][name] for name in FIELDS], PIECES_ROUNDING, finest[0]["displacement_error"]
    errors = [np.abs(result[name] - value).max(axis=1) - rounding * np.abs(value).max() for name, value in zip(FIELDS, values)]
    errors[0] = errors[0] - own
    return [np.maximum(error, 0) for error in errors], [np.abs(value).max(axis=1) for value in values]


def judge(program: Path, drawing: Drawn, beside: Path | None) -> Judged | None:
    found = run(program, drawing, drawing.modes)
    compared = None if found is None else errors_of(program, drawing, found[0])
    if found is None or compared is None:
        return None
    result, seconds = found
    errors, peaks = compared
    missed = errors[0].max() / (drawing.modes["tolerance"] * peaks[0].max()) if "tolerance" in drawing.modes else 0.0
    seen = [error > 0 for error in errors]
    estimates = [(result[f"{name}_error"] / np.where(some, error, 1))[some & (error < tails.SMALL * peak)]
                 for name, some, error, peak in zip(FIELDS, seen, errors, peaks)]
    bound = (np.ma.filled(result["displacement_bound"], np.inf) / np.where(seen[0], errors[0], 1))[seen[0]]
    other = run(beside, drawing, drawing.modes) if beside and "tolerance" in drawing.modes else None
    return Judged(drawing.kind, missed, bound, estimates, (int(result["mode_count"]), seconds),
                  None if other is None else (int(other[0]["mode_count"]), other[1]))


def table(rows: list[Judged]) -> Iterator[str]:
    yield "| class | runs | largest error over the tolerance | bound over error | estimate over error: displacement | velocity | modes, CPU beside |"
    yield "|---|---|---|---|---|---|---|"
    for kind in [*dict.fromkeys(row.kind for row in rows), "all"]:
        some = [row for row in rows if kind in (row.kind, "all")]
        ratios = [np.concatenate([row.bound for row in some])] + [np.concatenate([row.estimate[i] for row in some]) for i in (0, 1)]
        pairs = [(row.cost[0] / row.beside[0], row.cost[1] / row.beside[1]) for row in some if row.beside]
        yield f"| {kind} | {len(some)} | {max(row.missed for row in some):.2f} | " + " | ".join(
            f"{values.min():.2f}, median {np.median(values):.1f}" if len(values) else "–" for values in ratios) + " | " + (
            "median {:.2f}, {:.2f}".format(*np.median(pairs, axis=0)) if pairs else "–") + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=2, help="scenes of each class with each kind of record")
    parser.add_argument("--beamwave", type=Path, default=PROGRAM)
    parser.add_argument("--beside", type=Path, help="another build of the program")
    options = parser.parse_args()
    rows, refused = [], 0
    for drawing in drawn(options.draws):
        row = judge(options.beamwave.resolve(), drawing, options.beside and options.beside.resolve())
        if row is None:
            refused += 1
            continue
        rows.append(row)
        if row.missed > 1 or any(values.size and values.min() < 1 for values in [row.bound, *row.estimate]):
            print(drawing.kind, drawing.modes, dict(drawing.groups[1:]), row, file=sys.stderr, flush=True)
    print("\n".join(table(rows)))
    print(f"{refused} runs were refused, ended without trust or took too long.")


if __name__ == "__main__":
    main()
