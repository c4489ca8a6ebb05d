"""The modal sum as two matrix products: β(aB + b)Δt = βaBΔt + βbΔt, so few sines are taken and BLAS does the rest."""

from __future__ import annotations

import numpy as np

from .modes import amplitudes, roots
from .peer import Peer, timed
from .problem import Problem

BLOCK = 4096  # modes in one product


def sum_of_sines(weights: np.ndarray, beta: np.ndarray, samples: int, step: float) -> np.ndarray:
    """Σ_k weights[p, k] sin(beta[k] j step) for j = 0 … samples − 1, (points, samples)."""
    inner = 1 << (max(samples - 1, 1).bit_length() + 1) // 2
    outer = -(-samples // inner)
    total = np.zeros((len(weights), outer, inner))
    for first in range(0, len(beta), BLOCK):
        part = slice(first, first + BLOCK)
        coarse = np.outer(np.arange(outer) * (inner * step), beta[part])
        fine = np.outer(beta[part], np.arange(inner) * step)
        sines, cosines = np.sin(fine), np.cos(fine)
        coarse_sines, coarse_cosines = np.sin(coarse), np.cos(coarse)
        for point, weight in enumerate(weights[:, part]):
            total[point] += (coarse_sines * weight) @ cosines
            total[point] += (coarse_cosines * weight) @ sines
    return total.reshape(len(weights), -1)[:, :samples]


@timed
def solve(problem: Problem, modes: int) -> np.ndarray:
    """Sum `modes` modes at all times."""
    weights, beta = amplitudes(problem, roots(modes, problem.mass_ratio))
    return sum_of_sines(weights, beta, problem.samples, problem.duration / problem.samples)


PEER = Peer(
    "numpy, matrix products",
    "the same sum by the addition theorem over a grid of times, in BLAS",
    solve,
    settings=tuple({"modes": n} for n in (10, 30, 100, 300, 1000, 3000, 10000, 30000)),
    small=({"modes": 10}, {"modes": 30}),
)
