"""The beam's line between the points of a result."""

from __future__ import annotations

from typing import TYPE_CHECKING, Callable

import numpy as np
import xarray as xr

from ..result import NothingToDraw
from .describe import effects_of

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

FEW_POINTS = 9  # a line through fewer has not the beam's form
SAME_PLACE = 1e-9  # positions are typed as decimals
FORCES = ("bending_moment", "shear_force")  # in the beam, also at a root that rests


def moving_points(case: xr.Dataset) -> np.ndarray:
    """Indices of the points that can move, by their place, each place once; raises `NothingToDraw` without one.

    The root is one of them on an elastic support only.
    """
    positions = case["point_position"].values
    places, order = np.unique(np.round(positions / SAME_PLACE), return_index=True)
    if is_clamped(case):
        order = order[places > 0.5]
    if not order.size:
        raise NothingToDraw("the only point is the clamped root")
    return order


def is_clamped(case: xr.Dataset) -> bool:
    """Whether the root is clamped, as it is without an elastic support."""
    return "support" not in effects_of(case)


def places_of_line(case: xr.Dataset, xi: np.ndarray, count: int) -> np.ndarray:
    """`count` places ξ, even, from where the line of `beam_line` starts to the last of the points at `xi`."""
    return np.linspace(0.0 if is_clamped(case) else xi[0], xi[-1], count)


def beam_line(case: xr.Dataset, xi: np.ndarray, deflection: np.ndarray) -> CubicSpline:
    """Line of the beam (place → deflection, times) through `deflection` (times, points) at `xi`, ascending.

    The cubic spline through the points, without curvature at a last one that is a free tip. A clamped root
    is one of its points, with no slope; on an elastic support the line starts at the first point.
    """
    from scipy.interpolate import CubicSpline  # here, since few pictures need it and it takes 0.7 s to import

    none = np.zeros(len(deflection))
    tip = "not-a-knot" if "tip_support" in effects_of(case) else (2, none)
    if is_clamped(case):
        values = np.vstack((none, deflection.T))
        return CubicSpline(np.concatenate(([0.0], xi)), values, bc_type=((1, none), tip))
    if xi.size < 2:
        raise NothingToDraw("on an elastic support one point makes no line")
    return CubicSpline(xi, deflection.T, bc_type=("not-a-knot" if xi.size > 2 else (2, none), (2, none)))


def force_line(xi: np.ndarray, values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Line (place → value, times) straight between `values` (times, points) at `xi`: moments have kinks, and forces steps."""

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
