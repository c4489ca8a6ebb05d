"""Mode shapes along the beam, one above the other."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.curves import panels_of, where_it_varies
from ..parts.labels import axis_label
from ..parts.places import mark_places
from ..parts.select import Chosen, chosen, left_out
from ..parts.sheet import Given, sheet_for
from ..parts.units import with_unit
from ..result import require
from ..style import GREY, styled

MAX_MODES = 6
HALF = 0.42  # of the distance between two modes that the largest deflection takes
SAMPLES_PER_WAVE = 6  # of a mode, that a line through the samples shows its form


@styled
def mode_shapes(ds: xr.Dataset, *, modes: Chosen = None, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `mode_shape` (case, mode, profile) of the lowest modes, or of these `modes`, each on its own zero line.

    Every shape has one largest deflection; beside it stands the frequency, or that the mode grows. A shape with too few
    samples for its waves is drawn as samples alone, with a note.
    """
    ds = chosen(ds, modes=modes, cases=cases)
    require(ds, "mode_shape", "profile_position")
    there = ds.sizes["mode"]
    ds = ds.isel(mode=slice(MAX_MODES if modes is None else None))
    varying, same = where_it_varies(ds, "mode_shape")
    drawn = panels_of(varying, "mode_shape", panels=1)
    alone = len(drawn.curves) == 1 and not same
    count, position = ds.sizes["mode"], ds["profile_position"].values
    sheet = sheet_for(ax, height=max(0.75 * count, 1.5) + 0.7)
    axes = sheet.axes[0]
    coarse = []
    for curve in drawn.curves:
        for row, (number, shape) in enumerate(zip(ds["mode"].values, curve.data["mode_shape"].values)):
            largest = np.nanmax(np.abs(shape), initial=0.0) or 1.0
            line = number / 2.0 * SAMPLES_PER_WAVE <= position.size - 1
            coarse += [] if line else [int(number)]
            style = {**curve.style, "marker": "" if line else ".", **({} if line else {"linestyle": ""})}
            axes.plot(position, row + HALF * shape / largest, label=curve.label or None if row == 0 else None, **style)
    for row in range(count):
        axes.axhline(row, color=GREY, linewidth=0.6, zorder=0)
    axes.set_yticks(
        range(count),
        [
            f"mode {number}{_frequency(drawn.curves[0].data, row) if alone else ''}"
            for row, number in enumerate(ds["mode"].values)
        ],
    )
    mark_places(axes, ds, "x")
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set(xlim=(position.min(), position.max()), ylim=(-0.6, count - 0.4), xlabel=axis_label(ds["profile_position"]))
    few = f"{position.size} samples do not show modes {', '.join(map(str, sorted(set(coarse))))}" if coarse else ""
    return sheet.finish(ds, [*drawn.notes, same, left_out(count, there, "modes in the file"), few])


def _frequency(case: xr.Dataset, row: int) -> str:
    """Second line of a mode's name: its frequency, or that it grows."""
    if "angular_frequency" not in case:
        return ""
    beta = float(case["angular_frequency"][row])
    if np.isfinite(beta):
        return f"\n{with_unit(beta / (2.0 * np.pi), 'Hz')}"
    return "\ngrows" if float(case.get("growth_rate", xr.zeros_like(case["angular_frequency"]))[row]) > 0.0 else ""
