"""HLSVDPROPY: the state space of a Hankel matrix, as spectroscopists use it; one complex history."""

from __future__ import annotations

import time

import numpy as np

from .cells import Cell, Draw, lines_of
from .tool import Lines, Tool, one_even_sensor


def estimate(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
    """One record after the other; of a pair of conjugate lines the one with positive frequency."""
    from hlsvdpropy import hlsvdpro

    start = time.process_time()
    found = []
    for draw in draws:
        answer = hlsvdpro(draw.values[:, 0].astype(complex), 2 * lines_of(cell), m=cell.samples // 2)
        frequencies, decays = np.asarray(answer[2]), -np.asarray(answer[3])
        upper = frequencies > 0
        found.append(Lines(frequencies[upper], decays[upper]))
    return found, time.process_time() - start


TOOL = Tool("hlsvdpropy", "the number of lines", estimate, one_even_sensor, ("hlsvdpropy",), slow=True)
