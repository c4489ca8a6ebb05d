"""Error against seconds, beamwave beside what else one could pick."""

from __future__ import annotations

import argparse
import sys

from beamwave_postproc.style import COLOURS
from common.bench import Bench, Measured
from common.document import measured_with
from matplotlib.figure import Figure

from . import beamwave, hermite, opensees, sums
from .beam import Problem
from .comparison import DASHED, LINE, Curve, details, diagram, measure, own_curve, summary
from .reference import MODES, check_digits, reference

BLOW = """\
&rotation  angular_velocity = {p.angular_velocity!r} /
&impact    mass_ratio = {p.mass_ratio!r} /
&capture   /
"""
PEERS = (*beamwave.peers_of(BLOW, 11), *sums.PEERS, hermite.PEER, opensees.PEER)
LEVELS = (2e-3, 1e-6, 1e-9, 1e-10)
SMALL, MODES_OF_SMALL = Problem(samples=512, duration=0.05), 2000

WORDS = """\
## Comparison with other methods

Made by `bench/peers.sh` ([bench/](../bench/README.md#the-peers) describes it). All compute the same quantity: the displacement of the paper's
beam after the capture (γ = 0.2, ω = 50 rad/s) at midpoint and tip, at {samples} times in {duration:g} s, from the scene's
numbers to the histories. Times are CPU seconds of one thread, medians of up to {rounds} interleaved runs. The row `beamwave` counts
its stages without start-up and files, which the others do not have; the whole process has a row of its own.

The error is the largest of either history over its own peak. (A tolerance refers to the larger peak, that of the tip, which is
2.5 times that of the midpoint.) The reference is {reference}.

![Error against seconds](pictures/peers.png)
"""

COSH_WORDS = "textbook cosh shapes:\ncancel from mode 12,\noverflow from 227"
CURVES = {
    "beamwave": own_curve("beamwave", -1, (-8, 0), "right"),
    "beamwave, whole process": own_curve("beamwave, whole\nprocess with files", -2, (9, 0), "left", DASHED),
    "numpy + FINUFFT": Curve(COLOURS[1], LINE, "s", "numpy +\nFINUFFT", 5, (-9, 0), "right"),
    "numpy, matrix products": Curve(COLOURS[5], LINE, "D", "numpy, matrix\nproducts", -1, (7, 0), "left"),
    "textbook cosh shapes": Curve(COLOURS[7], LINE, "X", COSH_WORDS, 0, (-34, -20), "right"),
    "Hermite elements, exact modes":
        Curve(COLOURS[3], LINE, "^", "Hermite elements,\nexact modes", -1, (8, -4), "left"),
    "OpenSees, Newmark": Curve(COLOURS[4], LINE, "P", "OpenSees, Newmark", 1, (0, 10), "left"),
}


def measured(options: argparse.Namespace) -> Measured:
    """The reference, then all peers."""
    problem, modes = (SMALL, MODES_OF_SMALL) if options.small else (Problem(), MODES)
    print("reference", file=sys.stderr, flush=True)
    exact, half = reference(problem, modes)
    digits = None if options.small else check_digits(problem)
    checked = "" if digits is None else f"; its first modes agree with 50 digits of mpmath to {digits:.0e}"
    return {
        "problem": {"samples": problem.samples, "duration": problem.duration},
        "reference": f"a sum of {modes} modes in extended precision (half as many differ by {half:.0e}{checked})",
        "rows": measure(PEERS, problem, exact, options.small),
    }


def section(measured: Measured) -> list[str]:
    """Text and tables."""
    rows = measured["rows"]
    rounds = max(row.get("runs", 1) for row in rows)
    words = WORDS.format(**measured["problem"], reference=measured["reference"], rounds=rounds)
    return [words, measured_with(measured["machine"]), summary(rows, PEERS, LEVELS), "All sizes:", details(rows)]


def draw(measured: Measured) -> Figure:
    """The work–precision diagram."""
    title = (
        rf"The beam after the capture, $\gamma$ = 0.2, $\omega$ = 50 rad s$^{{-1}}$: "
        f"midpoint and tip at {measured['problem']['samples']} times"
    )
    return diagram(measured["rows"], CURVES, title)


PACKAGES = ("numpy", "scipy", "finufft", "openseespy", "mpmath")
BENCH = Bench("peers", "error against seconds", measured, section, draw, PACKAGES)
