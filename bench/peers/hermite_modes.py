"""Finite elements, all their modes by LAPACK, and the modal sum: exact in time."""

from __future__ import annotations

import numpy as np

from . import hermite
from .numpy_products import sum_of_sines
from .peer import Peer, timed
from .problem import Problem


@timed
def solve(problem: Problem, elements: int) -> np.ndarray:
    """Histories of the mesh of `elements`."""
    from scipy.linalg import eigh

    squares, shapes = eigh(*hermite.matrices(problem, elements), overwrite_a=True, overwrite_b=True)
    modal = shapes.T @ hermite.starting_momentum(problem, elements)
    beta = np.sqrt(squares)
    weights = shapes[hermite.rows_of_points(problem, elements)] * (modal / beta)
    return sum_of_sines(weights, beta, problem.samples, problem.duration / problem.samples)


PEER = Peer(
    "Hermite elements, exact modes",
    "consistent mass, all modes of the mesh by LAPACK, the sum in matrix products",
    solve,
    settings=tuple({"elements": n} for n in (2, 4, 8, 16, 32, 64, 128, 256, 512)),
    small=({"elements": 2}, {"elements": 8}),
    packages=("scipy",),
)
