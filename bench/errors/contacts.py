"""Random scenes of contacts of a finite duration beside an integration of their own, and their estimates of errors beside far more modes.

`PYTHONPATH=bench python -m errors.contacts [--scenes 200] [--estimates 300] [--kind plain|initial|captures|loads|changes]`
takes half an hour. The integration (`tests/scenes/contact_reference.py`) has as many modes as the scene, so that only rounding and steps differ; it
knows no captures and no changes of bodies. BEAMWAVE_SEED sets the seed, BEAMWAVE another program.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import contact_reference
import contact_scenes
import numpy as np
from workplace import SECONDS, Workplace

from . import PROGRAM, SEED, spread
from .loads import run_in

NAMES = ("contacts", *contact_scenes.TIMES, "event_force", "event_impulse", *contact_scenes.HISTORIES)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=200, help="beside the integration")
    parser.add_argument("--estimates", type=int, default=300, help="beside more modes")
    parser.add_argument("--kind", choices=("plain", "initial", "captures", "loads", "changes"), default="plain",
                        help="a beam at rest, let go from a deflection, that captures the mass, under loads, or under loads while bodies come and leave")  # fmt: skip
    options = parser.parse_args()
    exact = judged(contact_scenes.judge, 0 if options.kind in ("captures", "changes") else options.scenes, options.kind)
    few = contact_scenes.FEW
    print(f"| largest error over the peak | undamped, up to {few} contacts | undamped, more | damped | least estimate over error |")
    print("|---|---|---|---|---|")
    for name in NAMES:
        own = [(damped, j) for damped, j in exact if j.quantity == name]
        kinds = [[j.part for damped, j in own if not damped and j.contacts <= few], [j.part for damped, j in own if not damped and j.contacts > few],
                 [j.part for damped, j in own if damped]]  # fmt: skip
        least = min((j.estimate for _, j in own), default=np.inf)
        print(f"| {name} | {' | '.join(f'{max(parts):.1e}' if parts else '–' for parts in kinds)} | {least:.3g} |")
    estimates = judged(contact_scenes.judge_estimates, options.estimates, options.kind)
    for name in contact_scenes.HISTORIES if options.estimates else ():
        print(f"{name:15} {spread([j.estimate for _, j in estimates if j.quantity == name])}")


def judged(judge, scenes: int, kind: str) -> list[tuple[bool, contact_scenes.Judged]]:
    """All that is judged, and whether the contact of its scene damps; what is below its error is said on standard error."""
    found, left_out = [], 0
    for number in range(scenes):
        rng = np.random.default_rng([SEED, number])
        scene = contact_scenes.draw(rng) if kind == "plain" else contact_scenes.draw_moving(rng, kind)
        with tempfile.TemporaryDirectory() as folder:
            try:
                own = list(judge(run_in(Workplace(PROGRAM, Path(folder))), scene))
            except (contact_reference.TooLongError, subprocess.TimeoutExpired):
                left_out += 1
                continue
        found += [("damping" in scene["contact"], j) for j in own]
        for j in own:
            if j.estimate < 1:
                print(f"below: scene {number}, {j}", file=sys.stderr, flush=True)
    if left_out:
        print(f"{left_out} of {scenes} scenes were left out, whose integration takes more than {contact_reference.MOST_STEPS} steps, or a run more than {SECONDS} s.")
    return found


if __name__ == "__main__":
    main()
