"""The bench as a whole."""

from __future__ import annotations

from pathlib import Path

from common.command import Bench, Measured
from common.machine import describe

from . import picture, table
from .measure import measure


def measured(program: Path, small: bool) -> Measured:
    """All rows, and where they were measured."""
    return {"machine": describe(program, ()), **measure(program, small)}


BENCH = Bench("price", "what accuracy costs", measured, table.FIRST, table.section, picture.save)
