"""The bench as a whole."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from common.command import Bench, Measured
from common.machine import describe

from . import picture, table
from .measure import PEERS, measure
from .problem import Problem
from .reference import MODES, check_digits, reference

PACKAGES = ("numpy", "scipy", "finufft", "openseespy", "mpmath")
SMALL = Problem(samples=512, duration=0.05)
MODES_OF_SMALL = 2000


def measured(program: Path, small: bool) -> Measured:
    """The reference, then all peers."""
    os.environ["BEAMWAVE"] = str(program)
    problem, modes = (SMALL, MODES_OF_SMALL) if small else (Problem(), MODES)
    print("reference", file=sys.stderr, flush=True)
    exact, half = reference(problem, modes)
    digits = None if small else check_digits(problem)
    checked = "" if digits is None else f"; its first modes agree with 50 digits of mpmath to {digits:.0e}"
    return {
        "problem": {"samples": problem.samples, "duration": problem.duration},
        "reference": f"a sum of {modes} modes in extended precision (half as many differ by {half:.0e}{checked})",
        "machine": describe(program, PACKAGES),
        "rows": measure(PEERS, problem, exact, small),
    }


BENCH = Bench("peers", "error against seconds", measured, table.FIRST, table.section, picture.save)
