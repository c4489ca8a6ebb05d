"""Legends that stay inside their figure: beside the curves where they fit, else above, in columns or broken lines."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend

CROWDED = 5  # more entries than this are set small
LONG = 30  # characters: a longer entry would hide the curves
TITLE_WIDTH = 72  # characters of a title in one line
BROKEN_AT = (100, 80, 60, 45, 30)  # characters in a line of an entry that is broken, tried in turn
SURE = 1.2  # times too wide by the number of characters: not to be tried
SIDES = 0.2  # inches kept free beside a legend
PAD = 0.05  # inches between legend and axes
GIVEN_HEIGHT = 0.5  # inches of legend that a figure has room for as it is


def add_legend(axes: Axes, title: str = "", *, above: bool = False) -> None:
    """Legend of what is labelled on `axes`; `above` the figure if told, or if long; the title alone if nothing is."""
    handles, labels = axes.get_legend_handles_labels()
    title = broken(title, TITLE_WIDTH)
    if not handles:
        if title and above:
            axes.set_title(title, fontsize="medium")
    elif above or max(len(as_read(label)) for label in labels) > LONG:
        _make_room(axes.figure, _fitting(axes.figure, handles, labels, title))
    else:
        axes.legend(title=title or None, fontsize="small" if len(handles) > CROWDED else None)


def as_read(text: str) -> str:
    """Text without its mathematical markup: about as many characters as are seen."""
    return re.sub(r"[$^{}]", "", re.sub(r"\\[a-z]+", "x", text))


def broken(text: str, width: int) -> str:
    """Break `text` after commas and semicolons, into lines that read as at most `width` characters if they can."""
    lines = [""]
    for part in re.split(r"(?<=[,;]) ", text):
        longer = f"{lines[-1]} {part}".strip()
        if lines[-1] and len(as_read(longer)) > width:
            lines.append(part)
        else:
            lines[-1] = longer
    return "\n".join(lines)


def _fitting(fig: Figure, handles: list, labels: list[str], title: str) -> Legend:
    """Return the legend at the top of `fig` in as many columns as fit, or in one with its entries broken."""
    layouts = [(columns, labels) for columns in range(len(labels), 0, -1)]
    layouts += [(1, [broken(label, width) for label in labels]) for width in BROKEN_AT]
    room = (fig.get_figwidth() - SIDES) * fig.dpi
    legend = _placed(fig, handles, labels, title, 1)
    a_character = max(text.get_window_extent().width for text in legend.get_texts()) / _characters(labels, 1)
    for columns, texts in layouts:
        last = texts is layouts[-1][1]
        if not last and _characters(texts, columns) * a_character > SURE * room:
            continue  # to set it only to see that would take most of the time that the picture takes
        legend.remove()
        legend = _placed(fig, handles, texts, title, columns)
        if legend.get_window_extent().width <= room:
            break
    return legend


def _placed(fig: Figure, handles: list, texts: list[str], title: str, columns: int) -> Legend:
    size = "small" if len(texts) > CROWDED else None
    return fig.legend(
        handles, texts, title=title or None, loc="upper center", ncols=columns, frameon=False, fontsize=size
    )


def _characters(texts: list[str], columns: int) -> int:
    """Characters side by side in the widest lines of all columns."""
    widths = [max(len(as_read(line)) for line in text.split("\n")) for text in texts]
    return sum(int(column.max()) for column in np.array_split(widths, columns))


def _make_room(fig: Figure, legend: Legend) -> None:
    """Heighten `fig` for the legend at its top, and keep the axes below that."""
    height = legend.get_window_extent().height / fig.dpi + PAD
    fig.set_figheight(fig.get_figheight() + max(0.0, height - GIVEN_HEIGHT))
    fig.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - height / fig.get_figheight()))
