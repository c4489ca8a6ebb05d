"""Which inputs explain the spread of what many cases came to, as bars."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.labels import input_words
from ..parts.outcome import rankings, strength
from ..parts.select import left_out
from ..parts.sheet import Given, columns_for, sheet_for
from ..style import COLOURS, styled

MOST_INPUTS, MOST_PANELS = 8, 8


@styled
def ranking(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw, for each outcome of a design or a sweep, the first-order index of the inputs that explain most of its spread, and
    their rank correlation with it. Raises what `rankings` does.
    """
    table = rankings(ds)
    panels = list(table.groupby("outcome", sort=False))
    rows = min(len(panels), MOST_PANELS)
    columns = columns_for(rows)
    bars = min(MOST_INPUTS, table["input"].nunique())
    sheet = sheet_for(ax, -(-rows // columns), columns, width=4.9 * columns, height=1.1 + 0.27 * bars)
    for axes, (words, one) in zip(sheet.axes, panels[:rows]):
        _draw(axes, one.set_index("input"))
        axes.set_title(words)
    for axes in sheet.axes[rows:]:
        axes.set_visible(False)
    alone = table["first_order_index"].notna().any()
    notes = [
        f"{table['cases'].max()} cases",
        "" if alone else "inputs are correlated, or many for so few cases, so that their shares of the variance cannot be told apart",
        left_out(bars, table["input"].nunique(), "inputs"),
        left_out(rows, len(panels), "results"),
    ]
    return sheet.finish(ds, notes)


def _draw(axes: Axes, table: pd.DataFrame) -> None:
    """Bars of one outcome, the input that explains most at the top."""
    table = table.loc[strength(table).sort_values(ascending=False).index[:MOST_INPUTS]]
    places = np.arange(len(table))
    index = table["first_order_index"].to_numpy()
    if np.isfinite(index).any():
        axes.barh(places, np.maximum(index, 0.0), height=0.62, color=COLOURS[5], label="share of the variance (first-order index)")
        axes.vlines(table["by_chance"], places - 0.4, places + 0.4, color="0.45", linewidth=1.0, label="exceeded by chance in 5 %")
    axes.plot(
        table["rank_correlation"], places, "D", color=COLOURS[2], markerfacecolor="white", markersize=4.5, label="rank correlation"
    )
    axes.axvline(0.0, color="0.3", linewidth=0.8)
    axes.set(xlim=(-1.04, 1.04), ylim=(len(table) - 0.4, -0.6), xticks=[-1.0, -0.5, 0.0, 0.5, 1.0])
    axes.set_yticks(places, [input_words(name) for name in table.index])
    axes.grid(visible=False, axis="y")
