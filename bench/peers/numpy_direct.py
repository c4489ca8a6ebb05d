"""The modal sum as numpy writes it: sines of all phases, in blocks that stay in cache, times the amplitudes."""

from __future__ import annotations

import numpy as np

from .modes import amplitudes, roots
from .peer import Peer, timed
from .problem import Problem

BLOCK = 1 << 17  # numbers in one block: 1 MB


@timed
def solve(problem: Problem, modes: int) -> np.ndarray:
    """Sum `modes` modes at all times."""
    weights, beta = amplitudes(problem, roots(modes, problem.mass_ratio))
    turns, times = beta / (2 * np.pi), problem.times
    displacement = np.empty((len(problem.points), problem.samples))
    step = max(BLOCK // modes, 1)
    for first in range(0, problem.samples, step):
        phases = np.outer(turns, times[first : first + step])
        phases -= np.rint(phases)  # numpy's sine is slow beyond a few million radians
        phases *= 2 * np.pi
        displacement[:, first : first + step] = weights @ np.sin(phases, out=phases)
    return displacement


PEER = Peer(
    "numpy, direct sum",
    "stable closed forms; sines of all phases in blocks, times the amplitudes",
    solve,
    settings=tuple({"modes": n} for n in (10, 30, 100, 300, 1000, 3000)),
    small=({"modes": 10}, {"modes": 30}),
)
