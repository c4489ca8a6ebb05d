"""A record's lines beside the modes of a beam."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.curves import Curve, panels_of
from ..parts.sheet import Given, sheet_for
from ..parts.units import number_text
from ..result import require
from ..style import ABOVE_GRID, COLOURS, GREY, styled

MODEL = "modelled_angular_frequency"


@styled
def record_model(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw by how much the measured frequencies of the modes differ from the modelled ones, and both decay rates.

    Bars are the intervals of the lines. The lower axes are empty without `&damping`. Lines that are no modes are left out.
    """
    require(ds, MODEL, "peak_mode", "measured_angular_frequency", "measured_angular_frequency_error")
    drawn = panels_of(ds, MODEL, panels=1)
    sheet = sheet_for(ax, 2, 1, height=2.7, share="x")
    above, below = sheet.axes
    for number, curve in enumerate(drawn.curves):
        _draw_differences(above, curve, 0.12 * (number - 0.5 * (len(drawn.curves) - 1)))
        _draw_decays(below, curve, 0.12 * (number - 0.5 * (len(drawn.curves) - 1)))
    above.axhline(0.0, color=GREY, linewidth=0.8, zorder=ABOVE_GRID)
    above.set_ylabel("Measured − modelled\nfrequency (%)")
    below.set(xlabel="Mode", ylabel="Decay rate (1/s)")
    below.xaxis.get_major_locator().set_params(integer=True)
    return sheet.finish(ds, [*drawn.notes, "bars: intervals of the lines", *verdict(ds)])


def _paired(case: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """The lines that are modes, and the numbers of these."""
    mode = case["peak_mode"].values
    lines = np.flatnonzero((mode > 0) & np.isfinite(case[MODEL].values))
    return lines, mode[lines].astype(float)


def _draw_differences(axes: Axes, curve: Curve, aside: float) -> None:
    lines, mode = _paired(curve.data)
    modelled = curve.data[MODEL].values[lines]
    away = 100.0 * (curve.data["measured_angular_frequency"].values[lines] / modelled - 1.0)
    bar = 100.0 * curve.data["measured_angular_frequency_error"].values[lines] / modelled
    axes.errorbar(mode + aside, away, bar, capsize=2, label=curve.label, **{**curve.style, "linestyle": ""})


def _draw_decays(axes: Axes, curve: Curve, aside: float) -> None:
    """Measured ones with bars; modelled ones as open marks."""
    if "measured_decay_rate" not in curve.data:
        return
    lines, mode = _paired(curve.data)
    values = curve.data["measured_decay_rate"].values[lines]
    bar = curve.data["measured_decay_rate_error"].values[lines]
    axes.errorbar(mode + aside, values, bar, capsize=2, **{**curve.style, "linestyle": ""})
    modelled = curve.data["modelled_decay_rate"].values[lines]
    if (modelled > 0.0).any():
        axes.plot(mode + aside, modelled, linestyle="", marker="_", markersize=14, color=COLOURS[2])


def verdict(ds: xr.Dataset) -> list[str]:
    """Whether noise explains the differences."""
    if "misfit_probability" not in ds or ds["misfit_probability"].ndim or int(ds["misfit_freedom"]) < 1:
        return []
    if float(ds["misfit_probability"]) >= 1e-3:
        return ["noise explains the differences"]
    return [f"noise does not explain the differences: frequencies are off by {number_text(100 * float(ds['model_scatter']), 2)} %"]
