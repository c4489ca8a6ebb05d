"""Random scenes: are tolerances kept, bounds held, estimates above the errors, and motions those of independent computations?

    PYTHONPATH=bench python -m errors [SUBJECT …] [--scenes N] [--kind KIND] [--seed 1] [--beamwave PROGRAM]

Each subject is held against what is written for it in tests/scenes: `tolerances` of the paper's beam against an independent sum of
many more modes, of beams of pieces against a far finer tolerance; `loads` against far more modes; `contacts` against an integration
by DOP853 with as many modes (`--kind` says what else happens), and against far more; `changes` of bodies against far more modes, and
against sums in 40 digits.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path
from typing import Any, Callable, Iterator, NamedTuple

import numpy as np
import xarray as xr
from common.bench import PROGRAM
from common.document import table

import contact_reference
import contact_scenes
import load_scenes
import make_timelines
import piece_tails
import tails
from test_timelines import estimates_over_errors, random_groups, text_of, unit_scene
from workplace import Workplace

LEAST, MOST = 1e-5, 1000  # tolerance and samples of the paper's beam: the independent sum takes a second
COUNTS, FINEST = (32, 64, 128), 640  # modes of changes


class Row(NamedTuple):
    """What is known of one number or history; LEFT_OUT of a scene that is refused, ends without trust or takes too long."""

    kind: str
    quantity: str
    estimate: float = np.inf  # over the error; infinite where there is nothing to judge
    error: float = np.nan  # over what is said of the subject


LEFT_OUT = "(left out)"


def tolerances(here: Workplace, options: argparse.Namespace) -> Iterator[Row]:
    """Estimates are 0 where an error is above its bound."""
    draws = options.scenes or 2
    for number, kind, record in product(range(draws), tails.KINDS, tails.RECORDS):
        for _, scene, *ways in tails.scenes(options.seed, kind, record, [number], LEAST, MOST):
            for modes in ways:
                yield from of_both(kind, tails.compare(here, scene, modes))
    for kind, _, _, groups, modes, finer in piece_tails.runs(draws, piece_tails.KINDS, tails.RECORDS, MOST, options.seed):
        yield from of_both(kind, piece_tails.compare(here, groups, modes, finer))


def of_both(kind: str, found: tuple | None) -> Iterator[Row]:
    """Displacement and velocity at each point of a run."""
    if found is None:
        yield Row(kind, LEFT_OUT)
        return
    for quantity, ratios in zip(("displacement", "velocity"), found[2:]):
        yield from (Row(kind, quantity, ratio, found[1]) for ratio in ratios)


def loads(here: Workplace, options: argparse.Namespace) -> Iterator[Row]:
    """Forces, motions of the base and of the hub, changes under them, and the end of a static deflection."""
    for kind in ("force", "base", "hub", "hub_base", "change", "let_go"):
        rng = np.random.default_rng(options.seed)
        for _ in range(options.scenes or 300):
            scene = load_scenes.draw(rng, kind)
            for j in load_scenes.judge(run_in(here), scene, int(rng.choice(load_scenes.COUNTS))):
                yield Row(kind, j.quantity, j.estimate, 1 / j.bound or np.nan)


def contacts(here: Workplace, options: argparse.Namespace) -> Iterator[Row]:
    """Of a finite duration; the integration knows no captures and no changes of bodies."""
    judges = {"integration": contact_scenes.judge, "more modes": contact_scenes.judge_estimates}
    if options.kind in ("captures", "changes"):
        del judges["integration"]
    for (against, judge), number in product(judges.items(), range(options.scenes or 300)):
        rng = np.random.default_rng([options.seed, number])
        scene = contact_scenes.draw(rng) if options.kind == "plain" else contact_scenes.draw_moving(rng, options.kind)
        kind = f"against {against}" + (", damped" if against == "integration" and "damping" in scene["contact"] else "")
        try:
            yield from (Row(kind, j.quantity, j.estimate, j.part) for j in judge(run_in(here), scene))
        except (contact_reference.TooLongError, subprocess.TimeoutExpired):
            yield Row(kind, LEFT_OUT)


def run_in(here: Workplace) -> Callable[[dict], xr.Dataset]:
    """What runs a scene; status 4 is that of one which is not known to its end."""

    def run(scene: dict) -> xr.Dataset:
        here.scene("scene", scene)
        ended = here.beamwave("run", "scene.nml", "--quiet", "--overwrite")
        if ended.returncode not in (0, 4):
            raise RuntimeError(ended.stderr)
        return here.dataset("scene")

    return run


def changes(here: Workplace, options: argparse.Namespace) -> Iterator[Row]:
    """Bodies and springs that come and leave."""

    def run(*groups: tuple) -> Any:
        here.write("a.nml", text_of(*groups))
        ended = here.beamwave("run", "a.nml", "--quiet", "--overwrite")
        return here.result("a") if ended.returncode == 0 else None

    for seed in range(options.scenes or 100):
        groups = random_groups(seed)
        few, finest = ([run(*groups, ("modes", {"before": n, "after": n})) for n in counts] for counts in (COUNTS, [FINEST]))
        for result in few:
            if result is None or finest[0] is None:
                yield Row("against more modes", LEFT_OUT)
                continue
            for name, ratios in estimates_over_errors(result, finest[0]).items():
                yield from (Row("against more modes", name, ratio) for ratio in ratios)
    for seed in range(1, 1 + (options.scenes or 100)):
        case = make_timelines.reference(seed, 5)
        result = run(*unit_scene(case))
        if result is None:
            yield Row("against 40 digits", LEFT_OUT)
            continue
        count = len(case["energies"])
        pairs = {name: (result[name], case[name]) for name in ("displacement", "velocity")}
        if count:
            energy, momentum = ([result[f"{name}_{when}"][:count] for when in ("before", "after")] for name in ("energy", "momentum"))
            pairs |= {"energies": (np.stack(energy, axis=1), case["energies"]), "momentum": momentum}
        for name, (one, other) in pairs.items():
            one, other = np.array(one), np.array(other)
            if np.abs(other).max() > 0:
                yield Row("against 40 digits", name, error=np.abs(one - other).max() / np.abs(other).max())


SUBJECTS = {  # and over what their errors are told
    tolerances: "the tolerance",
    loads: "its bound",
    contacts: "the peak",
    changes: "the peak",
}


def told(rows: list[Row], over: str) -> str:
    """A line for each kind and quantity."""
    heads = ["estimate over error: least", "median", "9 of 10 below", "below 1", f"largest error over {over}"]
    body = [["kind", "quantity", "number", *heads]]
    for kind, quantity in dict.fromkeys((row.kind, row.quantity) for row in rows):
        own = [row for row in rows if (row.kind, row.quantity) == (kind, quantity)]
        ratios = np.array([row.estimate for row in own if np.isfinite(row.estimate)])
        spread = [f"{value:.2g}" for value in np.quantile(ratios, [0, 0.5, 0.9])] if len(ratios) else ["–"] * 3
        errors = [row.error for row in own if np.isfinite(row.error)]
        spread += [str((ratios < 1).sum()), f"{max(errors):.2g}" if errors else "–"]
        body.append([kind, quantity, str(len(ratios) or len(own)), *spread])
    return table(body)


def main() -> None:
    """Print a table for each subject; what is below its error is said on standard error."""
    names = {subject.__name__: subject for subject in SUBJECTS}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("subjects", nargs="*", metavar="SUBJECT", help=", ".join(names))
    parser.add_argument("--scenes", type=int, help="of each kind (2, 300, 300, 100)")
    parser.add_argument("--kind", choices=("plain", "initial", "captures", "loads", "changes"), default="plain", help="of contacts")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--beamwave", type=Path, default=PROGRAM)
    options = parser.parse_args()
    for name in options.subjects or names:
        rows = []
        with tempfile.TemporaryDirectory() as directory:
            for row in names[name](Workplace(options.beamwave.resolve(), Path(directory)), options):
                rows.append(row)
                if row.estimate < 1:
                    print(row, file=sys.stderr, flush=True)
        print(f"{name}\n\n{told(rows, SUBJECTS[names[name]])}\n", flush=True)


if __name__ == "__main__":
    main()
