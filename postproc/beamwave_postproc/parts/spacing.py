"""How the values of an input are spaced, and the axis that suits them."""

from __future__ import annotations

from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from ..style import logarithmic
from .units import number_text

DECADES = 30.0  # between the least and the largest value, from where on an axis is logarithmic, however they are spaced
MARGIN = 1.2  # of a logarithmic axis
FEW = 5  # values, up to which each has its tick in the middle of its cells …
CLOSE = 1.0 / 12.0  # … unless two are so close, of the axis, that their numbers would meet


def is_logarithmic(values: np.ndarray) -> bool:
    """Whether the axis of these values is logarithmic: they are positive, and three or more of one ratio from each to the next, or span decades."""
    places = np.unique(values)
    if places.size < 2 or not places[0] > 0.0:
        return False
    ratios = places[1:] / places[:-1]
    return bool(places.size > 2 and np.allclose(ratios, ratios[0], rtol=1e-6)) or bool(places[-1] > DECADES * places[0])


def space_axis(axes: Axes, which: Literal["x", "y"], values: np.ndarray) -> None:
    """Make the axis of these values logarithmic where it is to be."""
    if is_logarithmic(values):
        logarithmic(axes, which, values.min() / MARGIN, values.max() * MARGIN)


def edges_of(values: np.ndarray) -> np.ndarray:
    """Where the cells of ascending values meet, and where the first and the last end: as far from their values as on the other side."""
    if is_logarithmic(values):
        return np.exp(_middles(np.log(values)))
    return _middles(values)


def space_cells(axes: Axes, which: Literal["x", "y"], values: np.ndarray) -> None:
    """End the axis where the cells of ascending values do, with a tick at each where they are few and apart."""
    ends = edges_of(values)[[0, -1]]
    steps = np.diff(np.log(values) if is_logarithmic(values) else values)
    if is_logarithmic(values):
        logarithmic(axes, which, *ends)
    axes.set(**{f"{which}lim": ends})
    if values.size <= FEW and steps.min() > CLOSE * steps.sum():
        axis = axes.xaxis if which == "x" else axes.yaxis
        axis.set_minor_locator(NullLocator())
        axis.set_ticks(values, [number_text(value) for value in values])


def _middles(values: np.ndarray) -> np.ndarray:
    middles = 0.5 * (values[1:] + values[:-1])
    return np.array([2.0 * values[0] - middles[0], *middles, 2.0 * values[-1] - middles[-1]])
