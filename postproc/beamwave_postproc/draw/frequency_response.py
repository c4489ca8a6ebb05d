"""Answers to a harmonic force: magnitude and phase against frequency."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.curves import panels_of
from ..parts.labels import axis_label, in_units
from ..parts.points import MAX_POINTS, shown_points
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import curve_style, logarithmic, styled

KIND = {"m N-1": "Receptance", "m s-1 N-1": "Mobility", "m s-2 N-1": "Accelerance"}
DEPTH = 1e-7  # what lies further below the highest resonance is not shown
RIGHT_ANGLE = 90.0  # degrees
# Degrees that no phase passes. A displacement lags the force up to −180, an acceleration leads it up to 180: what is 180 but for
# rounding stays on that side.
ENDS = {"m N-1": 179.0, "m s-1 N-1": 180.0, "m s-2 N-1": 181.0}


@styled
def frequency_response(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw the magnitude and the phase of `frequency_response_real` + i `frequency_response_imag` against frequency.

    A curve for each point; of a sweep one for each case, at the first point. The phase is drawn in degrees, within a turn, where
    something damps; without damping it is 0 or 180 degrees alone, and left out.
    """
    ds = chosen(ds, points=points, cases=cases)
    require(ds, "frequency_response_real", "frequency_response_imag", "response_frequency")
    drawn = panels_of(ds, "frequency_response_real", panels=1)
    shown, left = shown_points(ds, [curve.data for curve in drawn.curves], "frequency_response_real", MAX_POINTS)
    if len(drawn.curves) > 1:
        curves = [(curve.label, curve.style, _answer(curve.data, shown[0])) for curve in drawn.curves]
        left = f"at ξ = {ds['point_position'].values[shown[0]]:g}"
    else:
        names = [f"ξ = {ds['point_position'].values[point]:g}" for point in shown]
        curves = [(name, curve_style(i), _answer(drawn.curves[0].data, point)) for i, (name, point) in enumerate(zip(names, shown))]
    frequency = ds["response_frequency"].values
    height = max(np.nanmax(np.abs(answer), initial=0.0) for *_, answer in curves)
    if height == 0.0:
        raise NothingToDraw("the force moves none of these points")
    damped = any(np.nanmax(np.abs(answer.imag)) > 0.0 for *_, answer in curves)
    sheet = sheet_for(ax, 2 if damped else 1, share="x", height=2.6 if damped else 3.4)
    magnitude, lowest = sheet.axes[0], sheet.axes[-1]
    unit = ds["frequency_response_real"]
    end = ENDS.get(unit.attrs.get("units", ""), 180.0)
    for label, style, answer in curves:
        plain = {**style, "marker": "", "linewidth": 1.1}
        magnitude.plot(frequency, np.abs(answer), label=label, **plain)
        if damped:
            lowest.plot(*_phase(frequency, answer, end), **plain)
    for axes in sheet.axes:
        logarithmic(axes, "x", frequency[0], frequency[-1])
    low = min(np.nanmin(np.abs(answer)[np.abs(answer) > 0.0]) for *_, answer in curves if np.abs(answer).any())
    logarithmic(magnitude, "y", max(0.5 * low, DEPTH * height), 3.0 * height)
    magnitude.set_ylabel(KIND.get(unit.attrs.get("units", ""), "Magnitude") + in_units(unit))
    if damped:
        phases = np.concatenate([line.get_ydata() for line in lowest.lines])
        ends = [int(np.round(reduce(phases) / RIGHT_ANGLE)) for reduce in (np.nanmin, np.nanmax)]
        lowest.set(ylabel="Phase (degrees)", yticks=RIGHT_ANGLE * np.arange(ends[0], ends[1] + 1))
    lowest.set_xlabel(axis_label(ds["response_frequency"]))
    force = ds["frequency_response_position"]
    where = f"force at ξ = {float(force):g}" if force.size == 1 else ""
    return sheet.finish(ds, (*drawn.notes, where, left))


def _phase(frequency: np.ndarray, answer: np.ndarray, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and phases in degrees, within a turn that ends at `end`, with a gap in the curve where it begins anew.

    How many turns lie between two samples nobody can tell, since a sharp antiresonance turns a phase by 180 degrees either way.
    """
    phase = end - (end - np.degrees(np.angle(answer))) % 360.0
    anew = np.flatnonzero(np.abs(np.diff(phase)) > 180.0) + 1
    return np.insert(frequency, anew, frequency[anew]), np.insert(phase, anew, np.nan)


def _answer(case: xr.Dataset, point: int) -> np.ndarray:
    """Complex answer of one point."""
    return (case["frequency_response_real"][point] + 1j * case["frequency_response_imag"][point]).values
