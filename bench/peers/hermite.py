"""Cubic Hermite elements of the rotating beam with the mass on its tip and all their modes.

Lengths in units of the beam's length, masses of the beam's. Unknowns: deflection and slope of each node, root left out.
"""

from __future__ import annotations

import numpy as np

from .beam import Problem
from .comparison import Peer, timed
from .sums import sum_of_sines

STIFFNESS = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
MASS = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420


def matrices(problem: Problem, elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness less ω² times mass, s⁻², and consistent mass."""
    size = 1 / elements
    scale = np.array([1, size, 1, size])
    both = np.outer(scale, scale)
    speed = problem.h / problem.length**2
    stiffness = assemble(STIFFNESS * both * speed**2 / size**3, elements)
    mass = assemble(MASS * both * size, elements)
    mass[-2, -2] += problem.mass_ratio
    return stiffness - problem.angular_velocity**2 * mass, mass


def assemble(element: np.ndarray, elements: int, held: int = 2) -> np.ndarray:
    """The same matrix for each element; of the root's two unknowns so many are 0."""
    whole = np.zeros((2 * elements + 2, 2 * elements + 2))
    for first in range(0, 2 * elements, 2):
        whole[first : first + 4, first : first + 4] += element
    return whole[held:, held:]


def starting_momentum(problem: Problem, elements: int) -> np.ndarray:
    """The beam at rest, the mass at 1 m/s: mass matrix times the nodes' velocities."""
    momentum = np.zeros(2 * elements)
    momentum[-2] = problem.mass_ratio
    return momentum


def rows_of_points(problem: Problem, elements: int) -> list[int]:
    """Unknowns that are the deflection at the points, which must be nodes."""
    nodes = [xi * elements for xi in problem.points]
    if not all(node.is_integer() for node in nodes):
        raise ValueError(f"{elements} elements have no node at one of {problem.points}")
    return [2 * int(node) - 2 for node in nodes]


@timed
def by_modes(problem: Problem, elements: int) -> np.ndarray:
    """The modal sum of the mesh, exact in time."""
    from scipy.linalg import eigh

    squares, shapes = eigh(*matrices(problem, elements), overwrite_a=True, overwrite_b=True)
    modal = shapes.T @ starting_momentum(problem, elements)
    beta = np.sqrt(squares)
    weights = shapes[rows_of_points(problem, elements)] * (modal / beta)
    return sum_of_sines(weights, beta, problem.samples, problem.duration / problem.samples)


def at_samples(record: np.ndarray, problem: Problem) -> np.ndarray:
    """The record of the steps at the stored times: every so many of them, or interpolated."""
    from scipy.interpolate import CubicSpline

    steps = record.shape[1]
    if steps % problem.samples == 0:
        return record[:, :: steps // problem.samples]
    times = np.arange(steps) * (problem.duration / steps)
    return CubicSpline(times, record, axis=1)(problem.times)


PEER = Peer(
    "Hermite elements, exact modes",
    "consistent mass, all modes of the mesh by LAPACK, the sum in matrix products",
    by_modes,
    {"elements": (2, 4, 8, 16, 32, 64, 128, 256, 512)},
    {"elements": (2, 8)},
    ("scipy",),
)
