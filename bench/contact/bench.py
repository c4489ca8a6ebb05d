"""Error against seconds of a contact that lasts, beside OpenSees and Exudyn."""

from __future__ import annotations

import argparse
import sys

import numpy as np
from beamwave_postproc.style import COLOURS
from common.bench import Bench, Measured, Rows
from common.document import measured_with
from matplotlib.figure import Figure
from peers.beamwave import peers_of
from peers.comparison import DASHED, LINE, Curve, details, diagram, measure, own_curve, summary

from . import exudyn_stop, opensees
from .reference import MODES, Problem, reference

BLOW = """\
&impact    mass = {p.mass!r} /
&contact   stiffness = {p.stiffness!r}, exponent = 1 /
"""
PEERS = (*peers_of(BLOW, 10), opensees.PEER, exudyn_stop.PEER)
LEVELS = (1e-3, 1e-4, 1e-5, 1e-9)
SMALL, MODES_OF_SMALL = Problem(samples=100, duration=0.005), 40

WORDS = """\
## Contact of finite duration: OpenSees and Exudyn

Made by `bench/contact.sh` ([bench/](../bench/README.md#a-contact-that-lasts) describes it). All compute the same problem: a mass of 1 kg strikes the
tip of the paper's beam at 1 m/s through a linear stop of 1e6 N/m, leaves it after 2.6 ms and meets it again. Compared are the displacements of midpoint and
tip at {samples} times in {duration:g} s, with errors and times as [above](#comparison-with-other-methods). The reference is
{reference}.{ratio}

![Error against seconds](pictures/contact.png)
"""

CURVES = {
    "beamwave": own_curve("beamwave", 0, (-8, 0), "right"),
    "beamwave, whole process": own_curve("beamwave, whole\nprocess with files", -1, (9, 0), "left", DASHED),
    "OpenSees, Newmark": Curve(COLOURS[4], LINE, "P", "OpenSees, Newmark", -1, (8, 0), "left"),
    "Exudyn, Newmark": Curve(COLOURS[3], LINE, "^", "Exudyn, Newmark", 0, (-8, 0), "right"),
}


def measured(options: argparse.Namespace) -> Measured:
    """The reference, then all peers."""
    problem, modes = (SMALL, MODES_OF_SMALL) if options.small else (Problem(), MODES)
    print("reference", file=sys.stderr, flush=True)
    exact, half = reference(problem, modes)
    how = f"an integration of {modes} modes by DOP853 with a tolerance of 1e-13"
    return {
        "problem": {"samples": problem.samples, "duration": problem.duration},
        "reference": f"{how} (half as many modes differ by {half:.0e})",
        "rows": measure(PEERS, problem, exact, options.small),
    }


def section(measured: Measured) -> list[str]:
    """Text and tables."""
    rows = measured["rows"]
    words = WORDS.format(**measured["problem"], reference=measured["reference"], ratio=ratio(rows))
    return [words, measured_with(measured["machine"]), summary(rows, PEERS, LEVELS), "All sizes:", details(rows)]


def ratio(rows: Rows) -> str:
    """How much larger the others' smallest error is in the time of the program's whole process; empty if none is as fast."""
    known = [row for row in rows if row.get("error") is not None]
    others = {row["peer"] for row in known if not row["peer"].startswith("beamwave")}
    curves = [[row for row in known if row["peer"] == name] for name in others]
    own = [row for row in known if row["peer"] == "beamwave, whole process"]
    found = [min((error_within(curve, row["cpu_seconds"]) for curve in curves), default=np.inf) / row["error"] for row in own]
    found = [value for value in found if np.isfinite(value)]
    if not found:
        return ""
    return (
        " In the time of its whole process, including files, beamwave's error is smaller than the best of the others by a factor of "
        f"{min(found):.0e} to {max(found):.0e}.".replace("e+0", "e")
    )


def error_within(curve: Rows, seconds: float) -> float:
    """The smallest error that a peer reaches in a time, between its sizes by a power law; infinite if all take longer."""
    curve = sorted(curve, key=lambda row: row["cpu_seconds"])
    if seconds < curve[0]["cpu_seconds"]:
        return float("inf")
    errors = np.minimum.accumulate([row["error"] for row in curve])
    return float(np.exp(np.interp(np.log(seconds), np.log([row["cpu_seconds"] for row in curve]), np.log(errors))))


def draw(measured: Measured) -> Figure:
    """The work–precision diagram."""
    what = "A mass of 1 kg strikes the tip through a stop of 1e6 N/m: midpoint and tip"
    return diagram(measured["rows"], CURVES, f"{what} at {measured['problem']['samples']} times")


PACKAGES = ("numpy", "scipy", "openseespy", "exudyn")
BENCH = Bench("contact", "error against seconds, of a contact that lasts", measured, section, draw, PACKAGES)
