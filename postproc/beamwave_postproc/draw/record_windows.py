"""How frequency and damping of a record's lines change along it: its halves and quarters, each by itself."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.sensors import one_record
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, styled

MAX_LINES = 4
HALF = 0.6  # of a part of the record, whose longer ones are halves, shorter ones quarters
LOOKS = {"halves": {"color": COLOURS[1], "marker": "s"}, "quarters": {"color": COLOURS[2], "marker": "o"}}


@styled
def record_windows(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw frequency and damping ratio of the strongest lines in halves and quarters of the record, two axes a line.

    Bars are two standard deviations in the noise of each part, and as long as it is. The grey band is the interval of
    the whole record. Of a sweep the first case is drawn.
    """
    case, note = one_record(ds)
    names = ["measured_angular_frequency", "measured_decay_rate", "measured_amplitude"]
    require(case, *names, "window_angular_frequency", "window_decay_rate", "window_start", "window_end")
    lines = _strongest(case)
    sheet = sheet_for(ax, lines.size, 2, width=9.0, height=1.9 if lines.size > 1 else 2.8, share="x")
    for row, line in zip(sheet.grid, lines):
        _draw_frequency(row[0], case, line)
        _draw_damping(row[1], case, line)
    for axes in sheet.grid[-1]:
        axes.set(xlabel="Part of the record", xlim=(0.0, 1.0))
    count = int(np.isfinite(case["measured_angular_frequency"].values).sum())
    left = f"{lines.size} of {count} lines" if lines.size < count else ""
    return sheet.finish(case, [note, left, "bars: two standard deviations; band: the whole record's interval"])


def _strongest(case: xr.Dataset) -> np.ndarray:
    """The strongest lines that some part tells, by frequency."""
    told = np.isfinite(case["window_angular_frequency"].values).any(axis=1)
    strength = np.nan_to_num(case["measured_amplitude"].values).max(axis=0) * told
    order = [line for line in np.argsort(-strength) if strength[line] > 0.0]
    if not order:
        raise NothingToDraw("no part of the record tells a line by itself")
    return np.sort(order[:MAX_LINES])


def _draw_frequency(axes: Axes, case: xr.Dataset, line: int) -> None:
    """Its change from the frequency of the whole record, in Hz."""
    whole = case["measured_angular_frequency"].values[line]
    error = case["measured_angular_frequency_error"].values[line] / (2.0 * np.pi)
    values = (case["window_angular_frequency"].values[line] - whole) / (2.0 * np.pi)
    bounds = case["window_angular_frequency_bound"].values[line] / (2.0 * np.pi)
    prefix, factor = ("m", 1e3) if np.nanmax(np.abs(values)) < 0.1 else ("", 1.0)
    axes.axhspan(-factor * error, factor * error, color=GREY, alpha=0.25, linewidth=0.0)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    _draw_parts(axes, case, factor * values, factor * bounds)
    axes.set_ylabel(f"$f$ − {whole / (2.0 * np.pi):.6g} Hz ({prefix}Hz)")


def _draw_damping(axes: Axes, case: xr.Dataset, line: int) -> None:
    """The damping ratio in per cent."""
    beta, delta, half = (
        case[f"measured_{name}"].values[line] for name in ("angular_frequency", "decay_rate", "decay_rate_error")
    )
    rates, widths = (case[name].values[line] for name in ("window_decay_rate", "window_decay_rate_bound"))
    whole, values = (100.0 * rate / np.hypot(beta, rate) for rate in (delta, rates))
    error, bounds = (100.0 * beta**2 * width / np.hypot(beta, rate) ** 3 for rate, width in ((delta, half), (rates, widths)))
    axes.axhspan(whole - error, whole + error, color=GREY, alpha=0.25, linewidth=0.0)
    axes.axhline(whole, color=GREY, linewidth=0.8)
    _draw_parts(axes, case, values, bounds)
    axes.set_ylabel("Damping ratio (%)")


def _draw_parts(axes: Axes, case: xr.Dataset, values: np.ndarray, bounds: np.ndarray) -> None:
    """A bar for each part, as long as the part is and as high as its error."""
    start, end = case["window_start"].values, case["window_end"].values
    for words, look in LOOKS.items():
        mine = np.isfinite(values) & ((end - start > 0.4) == (words == "halves"))
        if not mine.any():
            continue
        axes.errorbar(
            0.5 * (start + end)[mine],
            values[mine],
            2.0 * bounds[mine],
            0.5 * (end - start)[mine],
            linestyle="",
            capsize=2,
            markerfacecolor="white",
            label=words,
            **look,
        )
