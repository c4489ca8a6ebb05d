"""How the lines that repeats of a record share differ from repeat to repeat, and what all repeats tell of them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..parts.select import left_out
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, styled

MAX_LINES = 4
NUMBERS = ["angular_frequency", "decay_rate"]


@styled
def record_repeats(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw frequency and decay rate by repeat for the lines that most repeats share, two axes a line.

    Bars are each repeat's own interval. The band is the interval from all repeats; between the dashed lines lies what
    one more repeat measures.
    """
    names = [f"{kind}_{name}" for name in NUMBERS for kind in ("measured", "pooled")]
    names += [f"pooled_{name}{part}" for name in NUMBERS for part in ("_error", "_next")]
    require(ds, "pooled_line", "pooled_count", *names)
    lines = _shared(ds)
    sheet = sheet_for(ax, lines.size, 2, width=9.0, height=1.9 if lines.size > 1 else 2.8, share="x")
    for row, line in zip(sheet.grid, lines):
        middle = float(ds["pooled_angular_frequency"][line]) / (2.0 * np.pi)
        away = float(ds["pooled_angular_frequency_error"][line]) / (2.0 * np.pi)
        prefix, factor = ("m", 1e3) if away < 0.1 else ("", 1.0)
        _draw(row[0], ds, "angular_frequency", line, factor / (2.0 * np.pi), factor * middle)
        row[0].set_ylabel(f"$f$ − {middle:.6g} Hz ({prefix}Hz)")
        _draw(row[1], ds, "decay_rate", line, 1.0, 0.0)
        row[1].set_ylabel("Decay rate (1/s)")
    for axes in sheet.grid[-1]:
        axes.set_xlabel("Repeat")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        axes.set_xlim(0.5, ds.sizes["case"] + 0.5)
    count = int((ds["pooled_count"].values > 0).sum())
    words = "band: interval from all repeats; between the dashed lines lies what one more measures"
    return sheet.finish(ds, [left_out(lines.size, count, "lines"), words])


def _shared(ds: xr.Dataset) -> np.ndarray:
    """The lines that most repeats have, by frequency."""
    counts = ds["pooled_count"].values
    order = [line for line in np.argsort(-counts, kind="stable") if counts[line] > 0]
    if not order:
        raise NothingToDraw("repeats share no line")
    return np.sort(order[:MAX_LINES])


def _draw(axes: Axes, ds: xr.Dataset, name: str, line: int, unit: float, zero: float) -> None:
    """One number of one line: each repeat's with its interval, and those of all; in another unit, from `zero`."""
    pooled, error, following = (unit * float(ds[f"pooled_{name}{part}"][line]) for part in ("", "_error", "_next"))
    if np.isfinite(pooled):
        axes.axhspan(pooled - zero - error, pooled - zero + error, color=GREY, alpha=0.25, linewidth=0.0)
        axes.axhline(pooled - zero, color=GREY, linewidth=0.8)
        for side in (-following, following):
            axes.axhline(pooled - zero + side, color=GREY, linewidth=0.8, linestyle="--")
    case, peak = np.nonzero(ds["pooled_line"].values == line + 1)
    values = unit * ds[f"measured_{name}"].values[case, peak] - zero
    own = f"measured_{name}_error"
    bars = unit * np.nan_to_num(ds[own].values[case, peak]) if own in ds else None
    look = {"marker": "o", "color": COLOURS[1], "markerfacecolor": "white"}
    axes.errorbar(case + 1, values, bars, linestyle="", capsize=2, **look)
