"""Bending waves at bodies and steps: the share of their power that is transmitted, against frequency."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.curves import panels_of
from ..parts.labels import axis_label
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import curve_style, logarithmic, styled

MAX_JUNCTIONS = 6


@styled
def transmission(ds: xr.Dataset, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `transmitted_power` against frequency; what is not transmitted is reflected.

    A curve for each body or step within the beam; of a sweep one for each case, at the first of them.
    """
    ds = chosen(ds, cases=cases)
    require(ds, "transmitted_power", "junction_position", "response_frequency")
    drawn = panels_of(ds, "transmitted_power", panels=1)
    place = drawn.curves[0].data["junction_position"].values
    left = ""
    if len(drawn.curves) > 1:
        curves = [(curve.label, curve.style, curve.data["transmitted_power"].values[0]) for curve in drawn.curves]
        left = "at the first body or step"
    else:
        shares = drawn.curves[0].data["transmitted_power"].values[:MAX_JUNCTIONS]
        curves = [(f"ξ = {place[i]:g}", curve_style(i), share) for i, share in enumerate(shares)]
        if place.size > MAX_JUNCTIONS:
            left = f"the first {MAX_JUNCTIONS} of {place.size}"
    curves = [curve for curve in curves if np.isfinite(curve[2]).any()]
    if not curves:
        raise NothingToDraw("no body or step within the beam")
    sheet = sheet_for(ax, 1, height=3.4)
    axes, frequency = sheet.axes[0], ds["response_frequency"].values
    for label, style, share in curves:
        axes.plot(frequency, share, label=label, **{**style, "marker": "", "linewidth": 1.1})
    logarithmic(axes, "x", frequency[0], frequency[-1])
    axes.set(xlabel=axis_label(ds["response_frequency"]), ylabel="Share of a wave's power\nthat is transmitted", ylim=(0.0, 1.03))
    return sheet.finish(ds, (*drawn.notes, left))
