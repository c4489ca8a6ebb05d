"""One look for all pictures: curves differ in dash and marker as well as in colour."""

from __future__ import annotations

import functools
from typing import Any, Callable, Literal, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

# The colours of Okabe and Ito, dark to light, told apart by the colour-blind too.
COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7F7F7F")
DASHES: tuple[Any, ...] = (
    "-",
    (0, (5, 2)),
    (0, (6, 1.5, 1, 1.5)),
    (0, (1, 1.2)),
    (0, (10, 3)),
    (0, (4, 1, 1, 1, 1, 1)),
    (0, (2, 2)),
    (0, (8, 1, 3, 1)),
)
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
MAX_CURVES = len(COLOURS)
GREY = "0.45"
ABOVE_GRID = 0.8  # order of drawing, below all data
# Of lines on an image, seen on its dark and its light parts, and in the legend beside it.
ON_IMAGE: dict[str, Any] = {"color": COLOURS[5], "path_effects": [withStroke(linewidth=2.4, foreground="black")]}
SUBS = ((np.log10(2.0), (1.0, 2.0, 5.0)), (np.log10(3.0), (1.0, 3.0)))  # numbers of a decade, and how close they are in it
FEW_DECADES = 1e3  # a ratio of limits below this is labelled between the decades too
PLAIN = (1e-3, 1e4)  # numbers that are written out, without powers of ten

RC: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.linewidth": 0.8,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 9.5,
    "font.size": 10.0,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "legend.framealpha": 0.9,
    "legend.handlelength": 3.4,
    "lines.linewidth": 1.3,
    "lines.markersize": 5.0,
}

Draws = TypeVar("Draws", bound=Callable[..., Figure])


def styled(draw: Draws) -> Draws:
    """Run a function that makes a figure under this package's settings, leaving the caller's alone."""

    @functools.wraps(draw)
    def wrapper(*args: Any, **kwargs: Any) -> Figure:
        with mpl.rc_context(RC):
            return draw(*args, **kwargs)

    return wrapper  # type: ignore[return-value]


def curve_style(index: int) -> dict[str, Any]:
    """Colour, dash and marker of curve `index` (0 …); open markers let coinciding curves show."""
    turn = index % MAX_CURVES
    return {
        "color": COLOURS[turn],
        "linestyle": DASHES[turn],
        "marker": MARKERS[turn],
        "markerfacecolor": "white",
        "markeredgewidth": 1.1,
    }


def sparse_markers(index: int, samples: int, count: int = 12) -> tuple[int, int]:
    """`markevery` of curve `index`: about `count` markers, staggered between curves."""
    step = max(samples // count, 1)
    return (index * step // 4) % step, step


def markers_to_end(index: int, samples: int) -> list[int]:
    """`markevery` of curve `index`: as `sparse_markers`, and one at the end, clear of the one before."""
    start, step = sparse_markers(index, samples)
    return [*range(start, samples - 1 - step // 2, step), samples - 1]


def logarithmic(axes: Axes, which: Literal["x", "y"], low: float, high: float) -> None:
    """Make one axis logarithmic from `low` to `high`: labelled by decades, and between where they are few."""
    axes.set(**{f"{which}scale": "log", f"{which}lim": (low, high)})
    label_decades(axes.xaxis if which == "x" else axes.yaxis, low, high)


def label_decades(axis: Axis, low: float, high: float) -> None:
    """Label a logarithmic axis from `low` to `high` by decades, and in plain numbers between where they are few."""
    if high < FEW_DECADES * low and low > PLAIN[0] and high < PLAIN[1]:
        axis.set_major_locator(FewDecades())
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


class FewDecades(LogLocator):
    """Ticks at 1, 2 and 5 of each decade, or at as many of these as have room."""

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """The ticks from `vmin` to `vmax`, on the axis as long as it is now."""
        room = self.axis.get_tick_space() / abs(np.log10(vmax / vmin))  # ticks in a decade
        self.set_params(subs=next((subs for closest, subs in SUBS if closest * room >= 1.0), (1.0,)))
        return super().tick_values(vmin, vmax)


def say_zero(axes: Axes) -> None:
    """Put 0 alone on the y axis of what is nothing but 0: any other number would be invented."""
    axes.set(ylim=(-1.0, 1.0), yticks=[0.0])
    write_in_middle(axes, "zero")


def write_in_middle(axes: Axes, words: str) -> None:
    """Write `words` just above the middle of the axes."""
    axes.annotate(words, (0.5, 0.5), xycoords="axes fraction", xytext=(0, 3), textcoords="offset points", ha="center")
