"""harminv: filter diagonalisation, by its command."""

from __future__ import annotations

import resource
import shutil
import subprocess

import numpy as np

from .cells import SPACED, Cell, Draw
from .tool import Lines, Tool, one_even_sensor

HALF_BAND = 0.03  # periods per step, either side of a line
OPTIONS = ("-f", "4", "-d", "1", "-Q", "1")  # as many functions as bins, strong damping allowed: the least error in a trial


def estimate(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
    """One call for each record, with a band around each place where lines are."""
    places = SPACED if not cell.near and len(cell.decays) == len(SPACED) else SPACED[1:2]
    bands = [f"{place - HALF_BAND:g}-{place + HALF_BAND:g}" for place in places]
    start = children()
    found = [of_text(call(bands, draw.values[:, 0])) for draw in draws]
    return found, children() - start


def call(bands: list[str], values: np.ndarray) -> str:
    """What the command prints."""
    text = "\n".join(map(repr, values.tolist()))
    return subprocess.run(["harminv", *OPTIONS, *bands], input=text, capture_output=True, text=True, check=True).stdout


def of_text(said: str) -> Lines:
    """Lines of its table: frequency, decay constant (of the amplitude), Q, amplitude, phase, error."""
    rows = [[float(cell) for cell in line.split(",")[:2]] for line in said.splitlines()[1:]]
    table = np.array(rows).reshape(-1, 2)
    return Lines(table[:, 0], table[:, 1])


def children() -> float:
    """CPU seconds of processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Command(Tool):
    """A tool that is a command."""

    def missing(self) -> str:
        return "" if shutil.which("harminv") else "the command harminv"


TOOL = Command("harminv", "a band around each line", estimate, one_even_sensor)
