"""What accuracy costs: error against seconds, the stages' shares, and the seconds of each further digit."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ..parts.sheet import Given, columns_for, mosaic_for
from ..parts.units import number_text, si_prefix
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, curve_style, logarithmic, styled

LADDERS = {1: "tolerance asked for", 2: "counts: before = after"}
CHEAP = 0.25  # of the time at hand, for a tenth of the error: a digit that costs no more is cheap
MARGIN = 2.0  # between curves and the frame of a logarithmic axis


@styled
def work_precision(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw a study of accuracy: error against seconds, the stages' shares, the price of each digit (three axes)."""
    require(ds, "true_error", "seconds", "ladder", "stage_seconds")
    timed = ds.isel(rung=np.flatnonzero(np.isfinite(ds["seconds"].values)))
    drawn = timed.isel(rung=np.flatnonzero(timed["true_error"].values > 0.0))
    if drawn.sizes["rung"] == 0:
        raise NothingToDraw("no rung has an error above zero and a time")
    layout, ratios = (["aa", "bc"], [1.7, 1.0]) if columns_for(2) == 2 else (["a", "b", "c"], [1.7, 1.0, 1.0])
    sheet = mosaic_for(ax, layout, ratios, width=7.2, height=7.4)
    above, shares, digits = sheet.axes
    _draw_errors(above, drawn)
    asked = timed.isel(rung=np.flatnonzero(timed["ladder"].values == 1))
    _draw_shares(shares, asked)
    _draw_digits(digits, asked)
    return sheet.finish(ds, [str(ds.attrs.get("machine", "")), _average(drawn)], legend=[above])


def _average(rungs: xr.Dataset) -> str:
    """What a digit costs on average, from the coarsest tolerance to the finest; empty where there are not two."""
    asked = rungs.isel(rung=np.flatnonzero(rungs["ladder"].values == 1))
    error, seconds = asked["true_error"].values, asked["seconds"].values
    if error.size < 2 or not error[-1] < error[0]:
        return ""
    growth = (seconds[-1] / seconds[0]) ** (1.0 / np.log10(error[0] / error[-1])) - 1.0
    words = f"{100.0 * abs(growth):.0f}% {'more' if growth >= 0.0 else 'less'} time"
    first, last = number_text(error[0], 2), number_text(error[-1], 2)
    return f"each digit takes on average {words}, from an error of {first} to {last}"


def _draw_errors(axes: Axes, rungs: xr.Dataset) -> None:
    """One curve for each ladder with quartiles as bars; what a cheap digit would cost; what is not resolved."""
    error, seconds = rungs["true_error"].values, rungs["seconds"].values
    for index, (ladder, label) in enumerate(LADDERS.items()):
        mine = rungs["ladder"].values == ladder
        if not mine.any():
            continue
        lower, upper = (rungs[name].values[mine] for name in ("seconds_lower", "seconds_upper"))
        spread = np.abs(np.stack([lower, upper]) - seconds[mine])
        axes.errorbar(error[mine], seconds[mine], spread, capsize=2, label=label, **curve_style(index))
    logarithmic(axes, "x", error.min() / MARGIN, error.max() * MARGIN)
    logarithmic(axes, "y", seconds.min() / MARGIN, seconds.max() * MARGIN)
    _draw_comparison(axes, error, seconds, rungs["ladder"].values == 1)
    floor = float(rungs.get("converged_error", np.nan))
    if error.min() / MARGIN < floor:
        axes.axvspan(error.min() / MARGIN, floor, color="0.93", zorder=0, label="not resolved by the converged run")
    axes.invert_xaxis()
    axes.set_xlabel("Largest error of any history over its peak")
    axes.set_ylabel("Seconds (median)")


def _draw_comparison(axes: Axes, error: np.ndarray, seconds: np.ndarray, asked: np.ndarray) -> None:
    """From the coarsest tolerance on, a quarter more time for each digit."""
    if not asked.any():
        return
    start = np.flatnonzero(asked)[0]
    reach = np.geomspace(error[start], error.min(), 50)
    digits = np.log10(error[start] / reach)
    label = f"for comparison: {CHEAP:.0%} more time for each digit"
    axes.plot(reach, seconds[start] * (1.0 + CHEAP) ** digits, color=GREY, linewidth=0.9, linestyle=":", label=label)


def _draw_shares(axes: Axes, rungs: xr.Dataset) -> None:
    """Stacked bars of the stages' parts of the time, for each tolerance."""
    stages = rungs["stage_seconds"].transpose("stage", "rung").values
    shares = 100.0 * stages / np.maximum(stages.sum(axis=0), np.finfo(float).tiny)
    below = np.zeros(shares.shape[1])
    places = np.arange(shares.shape[1])
    for index, (name, share) in enumerate(zip(_stage_names(rungs), shares)):
        style = {"color": COLOURS[(1, 2, 6)[index % 3]], "edgecolor": "white", "linewidth": 0.5}
        axes.bar(places, share, bottom=below, width=0.85, label=name, **style)
        below = below + share
    _label_tolerances(axes, rungs)
    axes.set_ylim(0.0, 100.0)
    axes.set_ylabel("Share of the time (%)")
    axes.grid(visible=False)
    axes.legend(fontsize="small", loc="lower center", ncols=3, bbox_to_anchor=(0.5, 1.0), handlelength=1.2)


def _draw_digits(axes: Axes, rungs: xr.Dataset) -> None:
    """Bars of the seconds of the next digit, with the growth in per cent on each; none where it is within the noise."""
    noise = rungs["digit_noise"].fillna(0.0).values if "digit_noise" in rungs else 0.0
    seconds = rungs["digit_seconds"].values
    known = seconds > noise
    seconds = np.where(known, seconds, np.nan)
    prefix, factor = si_prefix(seconds, "s")
    places = np.arange(seconds.size)
    bars = axes.bar(places, np.nan_to_num(factor * seconds), width=0.85, color=COLOURS[1])
    growth = rungs["digit_growth"].values
    labels = [f"{100 * part:+.0f}%" if above else "" for part, above in zip(growth, known)]
    axes.bar_label(bars, labels, fontsize="x-small", padding=1)
    axes.margins(y=0.15)
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    _label_tolerances(axes, rungs)
    axes.set_axisbelow(True)
    axes.set_ylabel(f"Price of the next digit ({prefix}s)")
    axes.grid(visible=False, axis="x")


def _label_tolerances(axes: Axes, rungs: xr.Dataset) -> None:
    """Powers of ten under every second bar."""
    decades = np.log10(rungs["tolerance"].values)
    axes.set_xticks(np.arange(decades.size)[::2], [rf"$10^{{{round(decade)}}}$" for decade in decades[::2]])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("Tolerance")


def _stage_names(rungs: xr.Dataset) -> list[str]:
    """Words of the stages, from the flags of their coordinate."""
    words = str(rungs["stage"].attrs.get("flag_meanings", "")).split()
    return words if len(words) == rungs.sizes["stage"] else [str(number) for number in rungs["stage"].values]
