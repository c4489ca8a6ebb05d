"""What a tool is asked, and what it answers."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .cells import Cell, Draw


@dataclass(frozen=True)
class Lines:
    """Lines that a tool reports of one record, in periods and e-folds per step; half widths of 95 % intervals if it has any."""

    frequencies: np.ndarray
    decays: np.ndarray
    frequency_errors: np.ndarray | None = None
    decay_errors: np.ndarray | None = None


@dataclass(frozen=True)
class Tool:
    """A tool of the comparison."""

    name: str
    told: str  # what it is told beyond the record
    estimate: Callable[[Cell, list[Draw]], tuple[list[Lines], float]]  # CPU seconds of all
    refuses: Callable[[Cell], str] = lambda cell: ""  # why it cannot do such records
    needs: tuple[str, ...] = ()  # Python packages
    slow: bool = False  # tries the few draws of a cell

    def missing(self) -> str:
        """What is not installed."""
        return ", ".join(name for name in self.needs if importlib.util.find_spec(name) is None)


def only_even(cell: Cell) -> str:
    """Why not, of a tool that knows no times."""
    return "takes even times alone" if cell.uneven else ""


def one_even_sensor(cell: Cell) -> str:
    """Why not, of a tool that takes one history."""
    return only_even(cell) or ("takes one sensor" if cell.sensors > 1 else "")


def of_poles(poles: np.ndarray) -> Lines:
    """Lines of the poles z of a real record: those above the real axis."""
    upper = poles[poles.imag > 0]
    return Lines(np.angle(upper) / (2 * np.pi), -np.log(np.abs(upper)))
