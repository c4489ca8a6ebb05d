"""Cubic Hermite elements: matrices of the rotating beam with the mass on its tip, and the state just after the blow.

Lengths in units of the beam's length, masses of the beam's. Unknowns: deflection and slope of each node, root left out.
"""

from __future__ import annotations

import numpy as np

from .problem import Problem

STIFFNESS = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
MASS = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
BANDWIDTH = 3


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


def assemble(element: np.ndarray, elements: int) -> np.ndarray:
    """The same matrix for each element; the root's two unknowns are 0."""
    whole = np.zeros((2 * elements + 2, 2 * elements + 2))
    for first in range(0, 2 * elements, 2):
        whole[first : first + 4, first : first + 4] += element
    return whole[2:, 2:]


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


def upper_band(matrix: np.ndarray) -> np.ndarray:
    """The matrix as LAPACK's banded routines take it, (BANDWIDTH + 1, unknowns)."""
    band = np.zeros((BANDWIDTH + 1, len(matrix)))
    for above in range(BANDWIDTH + 1):
        band[BANDWIDTH - above, above:] = np.diagonal(matrix, above)
    return band
