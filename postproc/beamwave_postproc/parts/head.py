"""The head of a figure: title, warning, inputs, notes and legend, above all axes and as wide as the figure."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from ..terminal import Refusal
from .crowding import MM, sufficient_size
from .describe import brief_of, description_of, title_of
from .labels import plain
from .text import broken, fitting, width_of

MARGIN = 0.12  # inches, left and right and at the top
LINES = 2  # of what a scene has
GAP = 0.05  # inches, between the parts
# Titles and file names are anybody's: a dollar in them begins no formula.
TITLE: dict[str, Any] = {"fontsize": 10.5, "fontweight": "bold", "parse_math": False}
WARNING: dict[str, Any] = {"fontsize": 8.5, "fontweight": "bold", "color": "firebrick", "parse_math": False}
SMALL: dict[str, Any] = {"fontsize": 8.5, "color": "0.25", "parse_math": False}
ENTRY = 9.0  # size of a legend's words
HANDLE, TEXT_PAD, COLUMN_GAP = 3.4, 0.6, 1.6  # of a legend, in its font's size


@dataclass
class Head:
    """What stands above the axes: a warning, lines of words, and a legend of these handles and labels.

    Of each list in `scenes`, groups of a scene, two lines show what has room; `about` is all that there is to say of the scene, which
    the figure's label holds.
    """

    title: str
    lines: list[str]
    scenes: list[list[str]] = field(default_factory=list)
    about: str = ""
    handles: list[Any] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    warning: str = ""


def head_of(ds: xr.Dataset, notes: list[str], warning: str = "") -> Head:
    """Head of a picture of `ds`: which scene, which effects and inputs, and what has to be said of this picture."""
    lines = ["; ".join(filter(None, notes))]
    return Head(title_of(ds), lines, [brief_of(ds)], description_of(ds), warning=warning)


def add_head(fig: Figure, head: Head, *, grow: bool = True) -> None:
    """Write `head` at the top of `fig`, which grows by its height unless told, and keep the axes below it.

    Raises `Refusal` where a figure that does not grow has too little room for its axes and their words.
    """
    height = grow_by_head(fig, head, grow=grow)
    if not grow and (enough := sufficient_size(fig, height)) != tuple(fig.get_size_inches()):
        raise Refusal(f"the words of a picture have no room in this --size; {_in_words(enough)}")
    fig.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - height / fig.get_figheight()))


def _in_words(size: tuple[float, float]) -> str:
    """A size, which is of whole mm, and what it is good for."""
    if not all(map(math.isfinite, size)):
        return "draw it larger"
    return f"{MM * size[0]:.0f}x{MM * size[1]:.0f} mm suffices"


def grow_by_head(fig: Figure, head: Head, *, grow: bool = True) -> float:
    """Write `head` at the top of `fig`, which grows by its height unless told; returns that height in inches."""
    width = fig.get_figwidth() - 2.0 * MARGIN
    above = MARGIN
    placed = []
    fig.set_label(plain(f"{head.title}: {head.about}"))
    scenes = [fitting([plain(part) for part in scene], width, LINES, **SMALL) for scene in head.scenes]
    small = [*scenes, *map(plain, head.lines)]
    for text, style in [(head.title, TITLE), (plain(head.warning), WARNING), *((line, SMALL) for line in small)]:
        if text:
            artist = fig.text(0.0, 0.0, broken(text, width, **style), va="top", linespacing=1.25, **style)
            longer = artist.get_window_extent().width / fig.dpi / width
            if longer > 1.0:  # of a film, whose dots are coarser than those on which words are measured
                artist.set_text(broken(text, width / longer, **style))
            placed.append((artist, above))
            above += artist.get_window_extent().height / fig.dpi + GAP
    if head.handles:
        legend = _legend(fig, head, width)
        placed.append((legend, above))
        above += legend.get_window_extent().height / fig.dpi + GAP
    fig.set_figheight(fig.get_figheight() + (above if grow else 0.0))
    for artist, top in placed:
        place = (MARGIN / fig.get_figwidth(), 1.0 - top / fig.get_figheight())
        artist.set_bbox_to_anchor(place, fig.transFigure) if artist in fig.legends else artist.set_position(place)
    return above


def _legend(fig: Figure, head: Head, width: float) -> Any:
    """Legend in as many columns as fit into `width` inches, or in one with its entries broken."""
    em = ENTRY / 72.0
    beside = (HANDLE + TEXT_PAD) * em
    sizes = [width_of(label, fontsize=ENTRY) + beside for label in head.labels]
    columns = next((n for n in range(len(sizes), 0, -1) if _width(sizes, n, COLUMN_GAP * em) <= width), 1)
    labels = head.labels
    if max(sizes) > width:
        labels = [broken(label, width - beside, fontsize=ENTRY) for label in labels]
    return fig.legend(
        head.handles,
        labels,
        loc="upper left",
        borderaxespad=0.0,
        borderpad=0.0,
        ncols=columns,
        frameon=False,
        fontsize=ENTRY,
        handlelength=HANDLE,
        handletextpad=TEXT_PAD,
        columnspacing=COLUMN_GAP,
    )


def _width(sizes: list[float], columns: int, gap: float) -> float:
    """Inches that a legend takes in so many columns, filled one after another as matplotlib does."""
    rows, longer = divmod(len(sizes), columns)
    counts = [rows + 1] * longer + [rows] * (columns - longer)
    starts = [sum(counts[:i]) for i in range(columns)]
    return sum(max(sizes[start : start + count]) for start, count in zip(starts, counts)) + gap * (columns - 1)
