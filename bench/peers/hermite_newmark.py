"""Finite elements stepped in time by Newmark's method (average acceleration), each step one small matrix product."""

from __future__ import annotations

import numpy as np

from . import hermite
from .peer import Peer, timed
from .problem import Problem

BLOCK = 1024  # steps whose states are held


@timed
def solve(problem: Problem, elements: int, steps: int) -> np.ndarray:
    """March `steps` steps; a cubic spline fills in where the record has more samples."""
    stiffness, mass = hermite.matrices(problem, elements)
    start = np.linalg.solve(mass, hermite.starting_momentum(problem, elements))
    step = problem.duration / steps
    one_step = propagator(stiffness, mass, step)
    rows = hermite.rows_of_points(problem, elements)
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


SETTINGS = ((4, 1 << 12), (8, 1 << 14), (8, 1 << 16), (16, 1 << 18), (32, 1 << 20))

PEER = Peer(
    "Hermite elements, Newmark",
    "consistent mass, average acceleration, each step one matrix product",
    solve,
    settings=tuple({"elements": elements, "steps": steps} for elements, steps in SETTINGS),
    small=({"elements": 4, "steps": 256}, {"elements": 4, "steps": 1024}),
    packages=("scipy",),
)
