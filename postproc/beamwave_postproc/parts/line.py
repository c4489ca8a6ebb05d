"""The beam's line between the points of a result."""

from __future__ import annotations

from typing import Callable

import numpy as np
import xarray as xr

from ..result import NothingToDraw
from .describe import effects_of

Line = Callable[[np.ndarray], np.ndarray]  # place → value, times
FEW_POINTS = 9  # a line through fewer has not the beam's form
SAME_PLACE = 1e-9  # positions are typed as decimals
FORCES = ("bending_moment", "shear_force")  # in the beam, also at a root that rests


def moving_points(case: xr.Dataset) -> np.ndarray:
    """Indices of the points that can move, by their place, each place once; raises `NothingToDraw` without one.

    The root is one of them where it deflects.
    """
    positions = case["point_position"].values
    places, order = np.unique(np.round(positions / SAME_PLACE), return_index=True)
    if root_rests(case):
        order = order[places > 0.5]
    if not order.size:
        raise NothingToDraw("the only point is the root, which is held")
    return order


def is_clamped(case: xr.Dataset) -> bool:
    """Whether the root is clamped, as it is without an elastic support."""
    return "support" not in effects_of(case)


def root_rests(case: xr.Dataset) -> bool:
    """Whether the root does not deflect: it is clamped, or only turns."""
    return is_clamped(case) or "support_stiffness" not in case


def places_of_line(case: xr.Dataset, xi: np.ndarray, count: int) -> np.ndarray:
    """`count` places ξ, even, from where the line of `beam_line` starts to the last of the points at `xi`."""
    return np.linspace(0.0 if root_rests(case) else xi[0], xi[-1], count)


def beam_line(case: xr.Dataset, xi: np.ndarray, deflection: np.ndarray) -> Line:
    """Line of the beam through `deflection` (times, points) at `xi`, ascending.

    The cubic spline through the points, without curvature at a last one that is a free tip. A root that does not deflect
    is one of its points, with no slope where it is clamped; else the line starts at the first point.
    """
    x, y = xi, deflection.T
    if root_rests(case):
        x, y = np.concatenate(([0.0], xi)), np.vstack((np.zeros((1, len(deflection))), y))
    if x.size < 2:
        raise NothingToDraw("on an elastic support one point makes no line")
    other = "smooth" if x.size > 2 else "straight"
    tip = other if "tip_support" in effects_of(case) else "straight"
    return _spline(x, y, "flat" if is_clamped(case) else other, tip)


def _spline(x: np.ndarray, y: np.ndarray, first: str, last: str) -> Line:
    """The cubic spline through `y` (points, times) at `x`; its ends are 'flat', 'straight' (no curvature), or 'smooth' (not a knot).

    By hand, since the import of SciPy's interpolation takes as long as two pictures.
    """
    step = np.diff(x)
    slope = np.diff(y, axis=0) / step[:, None]
    system, right = np.zeros((x.size, x.size)), np.zeros_like(y, dtype=float)
    for i in range(1, x.size - 1):
        system[i, i - 1 : i + 2] = step[i], 2.0 * (step[i - 1] + step[i]), step[i - 1]
        right[i] = 3.0 * (step[i] * slope[i - 1] + step[i - 1] * slope[i])
    system[0, :2], right[0] = _end(step, slope, first)
    system[-1, :-3:-1], right[-1] = _end(step[::-1], slope[::-1], last)
    tangent = np.linalg.solve(system, right)

    def line(places: np.ndarray) -> np.ndarray:
        left = np.clip(np.searchsorted(x, places, side="right") - 1, 0, x.size - 2)
        whole = step[left, None]
        part = (places - x[left])[:, None] / whole
        rest = 1.0 - part
        bend = whole * part * rest * (rest * (tangent[left] - slope[left]) - part * (tangent[left + 1] - slope[left]))
        return rest * y[left] + part * y[left + 1] + bend

    return line


def _end(step: np.ndarray, slope: np.ndarray, kind: str) -> tuple[tuple[float, float], np.ndarray]:
    """What the condition at an end asks of the tangents at its first two points: their factors, and the sum."""
    if kind == "flat":
        return (1.0, 0.0), 0.0 * slope[0]
    if kind == "straight":
        return (2.0, 1.0), 3.0 * slope[0]
    if step.size == 1:
        return (1.0, 0.0), slope[0]
    two = step[0] + step[1]
    return (step[1], two), ((step[0] + 2.0 * two) * step[1] * slope[0] + step[0] ** 2 * slope[1]) / two


def force_line(xi: np.ndarray, values: np.ndarray) -> Line:
    """Line straight between `values` (times, points) at `xi`: moments have kinks, and forces steps."""

    def line(places: np.ndarray) -> np.ndarray:
        left = np.clip(np.searchsorted(xi, places, side="right") - 1, 0, xi.size - 2)
        part = ((places - xi[left]) / (xi[left + 1] - xi[left]))[:, None]
        return (1.0 - part) * values.T[left] + part * values.T[left + 1]

    return line


def whole_line(case: xr.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Places ξ and histories (time, point) of variable `name` at enough points for a form, each once: those that move, of a force all.

    Raises `NothingToDraw`, saying what to ask for, where the points are too few or do not reach the tip.
    """
    places = np.round(case["point_position"].values / SAME_PLACE)
    order = np.unique(places, return_index=True)[1] if name in FORCES else moving_points(case)
    xi = case["point_position"].values[order]
    if xi.size < FEW_POINTS or abs(xi[-1] - 1.0) > SAME_PLACE:
        raise NothingToDraw(f"needs {FEW_POINTS} points or more up to the tip, as &response points = 0.05, 0.1, … 1.0")
    return xi, case[name].values[order].T
