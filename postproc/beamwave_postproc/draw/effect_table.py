"""What each effect of a scene changes, and what it costs: the result of `beamwave effects` as a table in colours."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ..parts.labels import flag_words
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, sheet_for
from ..parts.units import number_text
from ..result import NothingToDraw, require
from ..style import GREY, styled

NOT_COMBINED = 3  # `effect_state`
SMALLEST = 1e-5  # change below which a cell is nearly white, or the scene's tolerance where that is larger
COLOURS = "RdBu_r"
DARK = 0.7  # of the scale, from where words are white
ROW, HEAD = 0.42, 0.6  # inches
SPARE = ("response", "run time")  # columns beside the modes
ROUNDING = 1e-10  # per cent, between two ways to find the same number


@styled
def changes(ds: xr.Dataset, *, modes: Chosen = None, ax: Given = None) -> Figure:
    """Change of each mode's frequency by each effect, of the response, and what the effect costs in time."""
    ds = chosen(ds, modes=modes)
    require(ds, "frequency_change", "effect_state", "response_change", "cost", "matters_from_mode")
    shown = np.flatnonzero(ds["effect_state"].values != NOT_COMBINED)
    there = np.flatnonzero(np.isfinite(ds["angular_frequency_without"].values).any(axis=0))
    if not shown.size or not there.size:
        raise NothingToDraw("no effect could be compared")
    rows = ds.isel(effect=shown, mode=there)
    width = 2.6 + 0.62 * (there.size + len(SPARE) + 1)
    sheet = sheet_for(ax, width=width, height=HEAD + ROW * shown.size)
    axes = sheet.axes[0]
    _draw_changes(axes, rows)
    _draw_spare(axes, rows)
    _name(axes, rows)
    words = "change of the frequencies, of the response (over its peak) and of the run's time by each effect"
    framed = f"framed: the first mode that it changes by more than {number_text(float(ds['frequency_tolerance']), 2)}"
    return sheet.finish(ds, [words, framed])


def _draw_changes(axes: Axes, rows: xr.Dataset) -> None:
    """One cell for each effect and mode; a frame around the first that matters."""
    change = rows["frequency_change"].values
    smallest = max(SMALLEST, float(rows["frequency_tolerance"]))
    largest = max(np.nanmax(np.abs(change), initial=0.0), 10.0 * smallest)
    norm = SymLogNorm(smallest, vmin=-largest, vmax=largest)
    axes.imshow(np.nan_to_num(change), cmap=COLOURS, norm=norm, aspect="auto")
    for row, column in np.ndindex(change.shape):
        value = change[row, column]
        dark = np.isfinite(value) and abs(norm(value) - 0.5) > 0.5 * DARK
        _write(axes, column, row, percent(value), "white" if dark else "black")
    for row, first in enumerate(rows["matters_from_mode"].values):
        if 0 < first <= change.shape[1]:
            axes.add_patch(_frame(first - 1, row))


def _frame(column: int, row: int) -> Rectangle:
    """Return a frame around one cell."""
    return Rectangle((column - 0.46, row - 0.44), 0.92, 0.88, fill=False, edgecolor="black", linewidth=1.4)


def _draw_spare(axes: Axes, rows: xr.Dataset) -> None:
    """The columns of response and time, apart from the modes."""
    modes = rows.sizes["mode"]
    for row in range(rows.sizes["effect"]):
        response, cost = (float(rows[name][row]) for name in ("response_change", "cost"))
        _write(axes, modes + 0.5, row, percent(response).lstrip("+"), "black")
        _write(axes, modes + 1.5, row, times(cost), "black")
    axes.axvline(modes - 0.5, color=GREY, linewidth=0.8)
    axes.set_xlim(-0.5, modes + len(SPARE))


def _name(axes: Axes, rows: xr.Dataset) -> None:
    """Names of rows and columns."""
    words = flag_words(rows["effect"])
    states = flag_words(rows["effect_state"])
    names = [
        f"{words[int(effect)].replace('_', ' ')} ({states[int(state)]})"
        for effect, state in zip(rows["effect"].values, rows["effect_state"].values)
    ]
    modes = rows.sizes["mode"]
    axes.set_yticks(range(len(names)), names)
    axes.set_xticks([*range(modes), modes + 0.5, modes + 1.5], [*(str(k) for k in rows["mode"].values), *SPARE])
    axes.tick_params(length=0, top=True, bottom=False, labeltop=True, labelbottom=False)
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.set_xlabel("Mode", loc="left")
    axes.xaxis.set_label_position("top")


def _write(axes: Axes, x: float, y: float, text: str, colour: str) -> None:
    """Words in the middle of a cell."""
    axes.text(x, y, text, ha="center", va="center", fontsize="small", color=colour)


def times(cost: float) -> str:
    """How many times as long, two digits; a dash for what does not exist."""
    return f"× {number_text(cost, 2)}" if np.isfinite(cost) else "–"


def percent(change: float) -> str:
    """Two digits and a sign, small ones as powers of ten, 0 for rounding; a dash for what does not exist."""
    if not np.isfinite(change):
        return "–"
    size = abs(100.0 * change)
    if size <= ROUNDING:
        return "0"
    sign = "+" if change > 0.0 else "−"
    if size < 1e-3:
        digit, power = f"{size:.0e}".split("e")
        return rf"{sign}{digit}·10$^{{{int(power)}}}$%"
    return f"{sign}{number_text(size, 2)}%"
