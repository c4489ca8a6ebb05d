"""Frequency over wave number of a record's lines, with the curve that they lie on."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.sensors import one_record
from ..parts.sheet import Given, sheet_for
from ..parts.units import number_text
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, logarithmic, styled


@styled
def record_dispersion(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw the frequency (Hz) of each line over its wave number, with β² = (EI/ρA) k⁴ − ω² as fitted to them, and below by how
    much each wave number is off that curve, with its interval: two axes.

    Of a sweep the first case is drawn.
    """
    case, note = one_record(ds)
    names = ["measured_wavenumber", "measured_wavenumber_error", "measured_angular_frequency", "measured_angular_frequency_error"]
    require(case, *names)
    wave, wave_error, beta, beta_error = (case[name].values for name in names)
    known = np.isfinite(wave) & np.isfinite(beta)
    if not known.any():
        raise NothingToDraw("no line has a wave number")
    sheet = sheet_for(ax, 2, 1, height=2.6, share="x")
    above, below = sheet.axes
    hertz, bars = beta[known] / (2.0 * np.pi), beta_error[known] / (2.0 * np.pi)
    ends = 0.7 * wave[known].min(), 1.4 * wave[known].max()
    look = {"linestyle": "", "marker": "o", "color": COLOURS[1], "markerfacecolor": "white", "capsize": 3}
    root = float(case["measured_stiffness_root"]) if "measured_stiffness_root" in case else np.nan
    words = ""
    if np.isfinite(root):
        turning = np.nan_to_num(float(case.get("measured_angular_velocity", np.nan)))
        grid = np.geomspace(*ends, 300)
        square = (root * grid**2) ** 2 - turning**2
        above.plot(grid[square > 0.0], np.sqrt(square[square > 0.0]) / (2.0 * np.pi), color=GREY, label="fitted dispersion")
        fitted = ((beta[known] ** 2 + turning**2) ** 0.5 / root) ** 0.5
        below.axhline(0.0, color=GREY)
        below.errorbar(wave[known], 100.0 * (wave[known] / fitted - 1.0), 100.0 * wave_error[known] / fitted, **look)
        error = number_text(float(case["measured_stiffness_root_error"]), 2)
        words = f"√(EI/ρA) = {number_text(root, 6)} ± {error} m²/s"
    elif sheet.own:
        below.set_visible(False)
    above.errorbar(wave[known], hertz, bars, wave_error[known], label="lines", **look)
    for axes in sheet.axes:
        logarithmic(axes, "x", *ends)
    logarithmic(above, "y", 0.5 * hertz.min(), 2.0 * hertz.max())
    above.set_ylabel("Frequency (Hz)")
    below.set(xlabel="Wave number $P$ (1/m)", ylabel="Measured − fitted\nwave number (%)")
    gone = int(np.count_nonzero(np.isfinite(beta) & ~known))
    return sheet.finish(case, [note, words, f"{gone} line{'s have' if gone > 1 else ' has'} no wave number" if gone else ""])
