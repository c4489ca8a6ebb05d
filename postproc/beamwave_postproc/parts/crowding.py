"""Whether the words of a figure have room, and how large it has to be for that."""

from __future__ import annotations

import math
import warnings
from itertools import combinations

import numpy as np
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

LEAST_ROW = 0.9  # inches, of a row of axes with its words
TOUCH = 1.0  # pixels, by which boxes may overlap
STEP, STEPS = 1.1, 16  # by which widths grow that are tried, and how often
HIGHER, MOST = 5, 4.0  # mm, by which heights grow that are tried, and how many times its own they are at most
MM = 25.4  # in an inch


def sufficient_size(fig: Figure, head: float) -> tuple[float, float]:
    """The size (width, height; inches) at which all words of `fig` have room below a head of so many inches.

    That of the figure itself if it suffices; else the least height, in steps of 5 mm, at its width, which is that of a column; and
    only where no height helps a larger width. (inf, inf) if none does.
    """
    own, least = tuple(fig.get_size_inches()), head + LEAST_ROW * fig.axes[0].get_gridspec().nrows

    def suffices(width: float, height: float) -> bool:
        """Whether words have room at this size (mm)."""
        fig.set_size_inches(width / MM, height / MM)
        if fig.get_figheight() < least:
            return False
        fig.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - head / fig.get_figheight()))
        return not is_crowded(fig)

    try:
        if suffices(MM * own[0], MM * own[1]):
            return own
        for wider in range(STEPS):
            width, low = math.ceil(MM * own[0] * STEP**wider), math.ceil(MM * own[1] / HIGHER) - 1
            high = math.ceil(MOST * MM * own[1] / HIGHER)
            if not suffices(width, HIGHER * high):
                continue
            while high - low > 1:
                middle = (low + high) // 2
                low, high = (low, middle) if suffices(width, HIGHER * middle) else (middle, high)
            return width / MM, HIGHER * high / MM
    finally:
        fig.set_size_inches(*own)
    return np.inf, np.inf


def is_crowded(fig: Figure) -> bool:
    """Whether axes with their words overlap or are cut, or numbers of an axis meet, wherever the axes were before."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fig.get_layout_engine().execute(fig)  # whose outcome depends a little on the places that it starts from
    with warnings.catch_warnings(record=True) as said:  # that axes have no room at all
        warnings.simplefilter("always")
        fig.get_layout_engine().execute(fig)
        shown = [axes for axes in fig.axes if axes.get_visible()]
        boxes = [axes.get_tightbbox(fig.canvas.get_renderer()) for axes in shown]
    whole = fig.bbox.padded(TOUCH)
    cut = any(box.x0 < whole.x0 or box.y0 < whole.y0 or box.x1 > whole.x1 or box.y1 > whole.y1 for box in boxes)
    apart = combinations(zip(shown, boxes), 2)
    meet = any(_overlap(p, q) for (a, p), (b, q) in apart if not np.allclose(a.bbox.bounds, b.bbox.bounds, atol=TOUCH))
    return bool(said) or cut or meet or any(_numbers_meet(axis) for axes in shown for axis in (axes.xaxis, axes.yaxis))


def _numbers_meet(axis: Axis) -> bool:
    boxes = [label.get_window_extent() for label in axis.get_ticklabels() if label.get_visible() and label.get_text()]
    return any(_overlap(p, q) for p, q in zip(boxes, boxes[1:]))


def _overlap(one: Bbox, other: Bbox) -> bool:
    across = min(one.x1, other.x1) - max(one.x0, other.x0)
    up = min(one.y1, other.y1) - max(one.y0, other.y0)
    return min(across, up) > TOUCH
