"""The bench as a whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from common.command import Bench, Measured
from common.machine import describe
from growth.measure import measure

from . import picture, table
from .records import AXES

SMALL_RECORD = 2**14  # samples of a trial run


def measured(program: Path, small: bool) -> Measured:
    """All rows, and where they were measured."""
    axes = [replace(axis, fixed=min(axis.fixed, SMALL_RECORD)) for axis in AXES] if small else AXES
    return {"machine": describe(program, ()), "rows": measure(program, axes, small)}


BENCH = Bench("large_records", "time and memory of a record's lines", measured, table.FIRST, table.section, picture.save)
