"""The layout of a figure: matplotlib's constrained one, in a fraction of its time."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable

from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

# What matplotlib works out of an axis eight times in each of two passes, by names that a version may lack.
ASKED = [name for name in ("_update_ticks", "_get_ticklabel_bboxes") if hasattr(Axis, name)]


class Layout(ConstrainedLayoutEngine):
    """Constrained layout that finds the ticks of an axis, and where their labels are, once for each place of its axes."""

    def execute(self, fig: Figure) -> None:
        """Lay out the figure; the drawing that follows finds its ticks anew."""
        lines = [axis for axes in fig.axes for axis in (axes.xaxis, axes.yaxis)]
        for axis in lines:
            vars(axis).update({name: partial(_once, {}, axis, getattr(axis, name)) for name in ASKED})
        try:
            super().execute(fig)
        finally:
            for axis in lines:
                for name in ASKED:
                    del vars(axis)[name]


def _once(found: dict[tuple[float, ...], Any], axis: Axis, find: Callable[..., Any], *given: Any) -> Any:
    """What `find` returns where the axes are now."""
    place = axis.axes.bbox.bounds
    if place not in found:
        found[place] = find(*given)
    return found[place]
