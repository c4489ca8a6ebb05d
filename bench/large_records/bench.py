"""The bench as a whole."""

from __future__ import annotations

from pathlib import Path

from common.command import Bench, Measured
from common.machine import describe
from growth.measure import measure

from . import picture, table
from .records import AXES


def measured(program: Path, small: bool) -> Measured:
    """All rows, and where they were measured."""
    return {"machine": describe(program, ()), "rows": measure(program, AXES, small)}


BENCH = Bench("large_records", "time and memory of a record's lines", measured, table.FIRST, table.section, picture.save)
