"""The bench as a whole."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from common.command import Bench, Measured
from common.machine import describe
from peers.measure import measure

from . import picture, table
from .peers_here import PEERS
from .problem import Problem
from .reference import MODES, reference

PACKAGES = ("numpy", "scipy", "openseespy", "exudyn")
SMALL = Problem(samples=100, duration=0.005)
MODES_OF_SMALL = 40


def measured(program: Path, small: bool) -> Measured:
    """The reference, then all peers."""
    os.environ["BEAMWAVE"] = str(program)
    problem, modes = (SMALL, MODES_OF_SMALL) if small else (Problem(), MODES)
    print("reference", file=sys.stderr, flush=True)
    exact, half = reference(problem, modes)
    return {
        "problem": {"samples": problem.samples, "duration": problem.duration},
        "reference": f"an integration of {modes} modes by DOP853 with a tolerance of 1e-13 (half as many modes differ by {half:.0e})",
        "machine": describe(program, PACKAGES),
        "rows": measure(PEERS, problem, exact, small),
    }


BENCH = Bench("contact", "error against seconds, of a contact that lasts", measured, table.FIRST, table.section, picture.save)
