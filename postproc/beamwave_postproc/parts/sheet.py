"""A sheet: the axes that a picture is drawn on, its own or its caller's, and the head above them."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from .head import Head, add_head, head_of
from .layout import Layout

SIZE: ContextVar[tuple[float, float] | None] = ContextVar("SIZE", default=None)  # of new figures, inches
LEAST_WIDTH = 3.0  # inches, of axes with their words that stand beside others
COMPRESSION = 3  # of PNG: a tenth larger than by default, and written in half the time
Given = Any  # axes of the caller: one, or a sequence or array of them, or None


@dataclass
class Sheet:
    """Axes in rows and columns, and whether their figure was made here."""

    grid: np.ndarray
    own: bool

    @property
    def axes(self) -> list[Axes]:
        """All axes, row by row."""
        return list(self.grid.ravel())

    @property
    def figure(self) -> Figure:
        """The figure of the axes."""
        return self.axes[0].figure

    def finish(
        self, ds: xr.Dataset, notes: Iterable[str] = (), legend: list[Axes] | None = None, warning: str = ""
    ) -> Figure:
        """Write the head of `ds` with `notes` and a `warning`, as `finish_with` does."""
        return self.finish_with(head_of(ds, list(notes), warning), legend)

    def finish_with(self, head: Head, legend: list[Axes] | None = None) -> Figure:
        """Write `head` with a legend of what is labelled on all axes, or on those in `legend`.

        A caller's figure gets the legend alone, on the first of the axes.
        """
        handles, labels = legend_of(self.axes if legend is None else legend)
        if self.own:
            add_head(self.figure, replace(head, handles=handles, labels=labels), grow=SIZE.get() is None)
        elif handles:
            self.axes[0].legend(handles, labels, fontsize="small")
        return self.figure


def sheet_for(
    ax: Given,
    rows: int = 1,
    columns: int = 1,
    *,
    width: float = 6.4,
    height: float = 4.0,
    share: str = "",
    ratios: list[float] | None = None,
) -> Sheet:
    """Axes in `rows` × `columns`: those in `ax` where given, else of a new figure.

    `width` of the figure and mean `height` of a row are in inches, `ratios` the heights of the rows to each other; `share` holds 'x' and 'y' where the axes of a column or
    of a row share a scale. Raises `ValueError` where `ax` is not as many axes as the picture has.
    """
    if ax is not None:
        return Sheet(given_axes(ax, rows * columns).reshape(rows, columns), own=False)
    shared = {"sharex": "col" if "x" in share else False, "sharey": "row" if "y" in share else False}
    shared |= {"height_ratios": ratios} if ratios else {}
    return Sheet(new_figure(width, height * rows).subplots(rows, columns, squeeze=False, **shared), own=True)


def mosaic_for(ax: Given, layout: list[str], ratios: list[float], *, width: float = 6.4, height: float = 4.0) -> Sheet:
    """One row of axes, given or new, which on a new figure lie as the letters of `layout` do, rows of these heights."""
    letters = list(dict.fromkeys("".join(layout)))
    if ax is not None:
        return Sheet(given_axes(ax, len(letters)).reshape(1, -1), own=False)
    made = new_figure(width, height).subplot_mosaic("\n".join(layout), height_ratios=ratios)
    return Sheet(np.array([[made[letter] for letter in letters]], dtype=object), own=True)


def columns_for(count: int, most: int = 2, least: float = LEAST_WIDTH) -> int:
    """How many of `count` axes stand beside each other: at most `most`, each at least so many inches wide where the size is given."""
    size = SIZE.get()
    return min(count, most, most if size is None else max(1, int(size[0] / least)))


def new_figure(width: float, height: float) -> Figure:
    """An empty figure apart from pyplot: no display is needed. In `of_size` it has that size."""
    fig = Figure(figsize=SIZE.get() or (width, height), layout=Layout())
    FigureCanvasAgg(fig)  # whose renderer stays while words are measured; another canvas makes one for each word
    return fig


def write_png(fig: Figure, target: Path | io.BytesIO, dpi: float, metadata: dict[str, str] | None = None) -> None:
    """Write a figure as PNG. It is drawn once: `savefig` draws twice, the first time for its layout alone."""
    fig.set_dpi(dpi)
    canvas = FigureCanvasAgg(fig)
    canvas.draw()
    told = PngInfo()
    for name, text in (metadata or {}).items():
        told.add_text(name, text)
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")  # no figure here is transparent
    image.save(target, "PNG", compress_level=COMPRESSION, dpi=(dpi, dpi), pnginfo=told)


@contextmanager
def of_size(size: tuple[float, float] | None) -> Iterator[None]:
    """Let figures that are made meanwhile have this width and height (inches), head and all; None: what each picture needs."""
    before = SIZE.set(size)
    try:
        yield
    finally:
        SIZE.reset(before)


def given_axes(ax: Given, count: int) -> np.ndarray:
    """The caller's axes as an array; raises `ValueError` unless they are `count`."""
    given = np.array(ax, dtype=object).ravel()
    if given.size != count:
        raise ValueError(
            f"the picture has {count} axes, and ax holds {given.size}: choose points or cases, or give as many"
        )
    return given


def legend_of(axes: list[Axes]) -> tuple[list[Any], list[str]]:
    """Handles and labels of all axes, each label once."""
    found: dict[str, Any] = {}
    for one in axes:
        for handle, label in zip(*one.get_legend_handles_labels()):
            found.setdefault(label, handle)
    return list(found.values()), list(found)
