"""A clamped beam's line between the points of a result."""

from __future__ import annotations

import numpy as np


def clamped_spline(points: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """Matrix (xi, points) that takes deflections at `points` to those at `xi`.

    The cubic spline through them and through the root, where deflection and slope are 0, without curvature at its last
    point: what a free tip has, and what a history without end conditions is given. `points` ascend and lie above 0, and
    `xi` lies between 0 and the last of them.
    """
    knots = np.concatenate(([0.0], points))
    values = np.vstack((np.zeros(points.size), np.eye(points.size)))  # one column per point
    curvature = np.linalg.solve(*_curvature_equations(knots, values))
    i = np.clip(np.searchsorted(knots, xi) - 1, 0, points.size - 1)
    step = (knots[1:] - knots[:-1])[i]
    right = (xi - knots[i]) / step
    left = 1.0 - right
    bend = ((left**3 - left) * step**2)[:, None] * curvature[i] + ((right**3 - right) * step**2)[:, None] * curvature[i + 1]
    return left[:, None] * values[i] + right[:, None] * values[i + 1] + bend / 6.0


def _curvature_equations(knots: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Left and right sides of the equations for the second derivatives at the knots."""
    step = np.diff(knots)
    slope = np.diff(values, axis=0) / step[:, None]
    last = knots.size - 1
    left, right = np.zeros((knots.size, knots.size)), np.zeros(values.shape)
    left[0, :2], right[0] = (2.0 * step[0], step[0]), 6.0 * slope[0]
    for i in range(1, last):
        left[i, i - 1 : i + 2] = step[i - 1], 2.0 * (step[i - 1] + step[i]), step[i]
        right[i] = 6.0 * (slope[i] - slope[i - 1])
    left[last, last] = 1.0
    return left, right
