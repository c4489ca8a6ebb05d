"""The bench as a whole."""

from __future__ import annotations

import os
from pathlib import Path

from common.command import Bench, Measured
from common.machine import describe

from . import picture, table
from .measure import measure

PACKAGES = ("numpy", "scipy", "hlsvdpropy", "pyOMA-2")


def measured(program: Path, small: bool) -> Measured:
    """All rows, and where they were measured."""
    os.environ["BEAMWAVE"] = str(program)
    return {"machine": describe(program, PACKAGES), "rows": measure(small)}


BENCH = Bench("records", "errors of lines in noise beside other tools", measured, table.FIRST, table.section, picture.save)
