"""The largest displacement, stress and contact force, restitution and last velocity of the mass over two inputs, as maps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.labels import in_units
from ..parts.outcome import OUTCOMES, Outcome, input_axis, outcomes_of, ranking_of, strength, varied_inputs
from ..parts.sheet import Given, columns_for, sheet_for
from ..parts.spacing import edges_of, space_cells
from ..parts.units import si_prefix, units_of
from ..result import NothingToDraw, swept_inputs
from ..style import styled

FEWEST = 4  # cases


@styled
def outcome_map(ds: xr.Dataset, *, inputs: Sequence[str] | None = None, ax: Given = None) -> Figure:
    """Map the largest displacement, stress and contact force, restitution and last velocity of the mass over two inputs that a sweep or a design varies.

    `inputs` are two of their variables, for x and y; else the two that explain most of the spread of what is drawn first. A
    grid of a sweep of two inputs is filled, of other cases each is a dot.
    """
    outcomes = [one for one in outcomes_of(ds) if one.variable.name in OUTCOMES] if "case" in ds.dims else []
    if not outcomes:
        raise NothingToDraw("no largest value, restitution or last velocity that differs from case to case")
    names = _inputs(ds, outcomes[0], inputs)
    columns = columns_for(len(outcomes))
    sheet = sheet_for(ax, -(-len(outcomes) // columns), columns, width=5.0 * columns, height=3.7)
    for axes, outcome in zip(sheet.axes, outcomes):
        _draw(axes, ds, outcome, names)
    for axes in sheet.axes[len(outcomes) :]:
        axes.set_visible(False)
    others = len(swept_inputs(ds)) - 2
    lacking = int(max(np.isnan(outcome.variable.values).sum() for outcome in outcomes))
    notes = [
        f"{ds.sizes['case']} cases",
        f"{others} more input{'s' if others > 1 else ''} vary from case to case" if others > 0 else "",
        f"{lacking} without numbers" if lacking else "",
    ]
    return sheet.finish(ds, notes)


def _inputs(ds: xr.Dataset, outcome: Outcome, given: Sequence[str] | None) -> list[str]:
    names = varied_inputs(ds)
    if given is not None:
        if len(given) != 2 or not set(given) <= set(names):
            raise NothingToDraw(f"inputs are two of those that vary: {', '.join(names)}")
        return list(given)
    if len(names) < 2 or ds.sizes["case"] < FEWEST:
        raise NothingToDraw("the cases do not vary two inputs")
    if len(names) == 2:
        return names[::-1]
    table = ranking_of(ds, names, outcome).set_index("input")
    return list(strength(table).sort_values(ascending=False).index[:2])


def _draw(axes: Axes, ds: xr.Dataset, outcome: Outcome, names: list[str]) -> None:
    x, y = (input_axis(axes, which, ds[name]) for which, name in zip("xy", names))
    values = outcome.variable.values
    held = np.isfinite(values)
    prefix, factor = si_prefix(values, units_of(outcome.variable))
    order = np.argsort(values[held])  # the largest on top
    columns, rows = np.unique(x), np.unique(y)
    if columns.size * rows.size == values.size and len(set(zip(x, y))) == values.size:
        grid = np.full((rows.size, columns.size), np.nan)
        grid[np.searchsorted(rows, y), np.searchsorted(columns, x)] = values * factor
        edges = edges_of(columns), edges_of(rows)
        drawn = axes.pcolormesh(*edges, np.ma.masked_invalid(grid), cmap="cividis", rasterized=True)
        for which, places in (("x", columns), ("y", rows)):
            space_cells(axes, which, places)
        axes.set_facecolor("0.75")
    else:
        size = float(np.clip(4000.0 / values.size, 3.0, 40.0))
        drawn = axes.scatter(
            x[held][order],
            y[held][order],
            c=(values[held] * factor)[order],
            s=size,
            cmap="cividis",
            linewidths=0.0,
            rasterized=values.size > 2000,
        )
    axes.figure.colorbar(drawn, ax=axes, label=outcome.words + in_units(outcome.variable, prefix))
    axes.grid(visible=False)
