"""Cubic Hermite elements of the rotating beam with the mass on its tip, by all their modes or by Newmark's method.

Lengths in units of the beam's length, masses of the beam's. Unknowns: deflection and slope of each node, root left out.
"""

from __future__ import annotations

import numpy as np

from .beam import Problem
from .comparison import Peer, timed
from .sums import sum_of_sines

STIFFNESS = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
MASS = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
BLOCK = 1024  # steps whose states are held


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


@timed
def by_newmark(problem: Problem, elements: int, steps: int) -> np.ndarray:
    """March `steps` steps; a cubic spline fills in where the record has more samples."""
    stiffness, mass = matrices(problem, elements)
    start = np.linalg.solve(mass, starting_momentum(problem, elements))
    step = problem.duration / steps
    one_step = propagator(stiffness, mass, step)
    rows = rows_of_points(problem, elements)
    states = np.empty((BLOCK + 1, len(one_step)))
    states[0] = np.concatenate([np.zeros_like(start), step / 2 * start])
    record = np.empty((steps, len(rows)))
    for first in range(0, steps, BLOCK):
        count = min(BLOCK, steps - first)
        for j in range(count):
            np.dot(one_step, states[j], out=states[j + 1])
        record[first : first + count] = states[:count, rows]
        states[0] = states[count]
    return at_samples(record.T, problem)


def propagator(stiffness: np.ndarray, mass: np.ndarray, step: float) -> np.ndarray:
    """One step of the method, which is linear, as one matrix on displacements and velocities times step/2.

    With a = −M⁻¹Ku eliminated: (M + Kh²/4)(u⁺ − u) = hMv − (h²/2)Ku and v⁺ = 2(u⁺ − u)/h − v.
    """
    softer = stiffness * (step**2 / 4)
    change = 2 * np.linalg.solve(mass + softer, np.hstack([-softer, mass]))
    same = np.eye(len(mass))
    none = np.zeros_like(same)
    return np.vstack([change + np.hstack([same, none]), change - np.hstack([none, same])])


def at_samples(record: np.ndarray, problem: Problem) -> np.ndarray:
    """The record of the steps at the stored times: every so many of them, or interpolated."""
    from scipy.interpolate import CubicSpline

    steps = record.shape[1]
    if steps % problem.samples == 0:
        return record[:, :: steps // problem.samples]
    times = np.arange(steps) * (problem.duration / steps)
    return CubicSpline(times, record, axis=1)(problem.times)


PEERS = (
    Peer(
        "Hermite elements, exact modes",
        "consistent mass, all modes of the mesh by LAPACK, the sum in matrix products",
        by_modes,
        {"elements": (2, 4, 8, 16, 32, 64, 128, 256, 512)},
        {"elements": (2, 8)},
        ("scipy",),
    ),
    Peer(
        "Hermite elements, Newmark",
        "consistent mass, average acceleration, each step one matrix product",
        by_newmark,
        {"elements": (4, 8, 8, 16, 32), "steps": (1 << 12, 1 << 14, 1 << 16, 1 << 18, 1 << 20)},
        {"elements": (4, 4), "steps": (256, 1024)},
        ("scipy",),
    ),
)
