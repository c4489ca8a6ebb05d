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
RIGHT_ANGLE, MANY = 90.0, 9  # degrees; ticks from where on every second is left out
END = 170.0  # degrees, that no phase passes: what is 180 but for rounding is drawn at −180


@styled
def frequency_response(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw the magnitude and the phase of `frequency_response_real` + i `frequency_response_imag` against frequency.

    A curve for each point; of a sweep one for each case, at the first point. The phase is drawn in degrees where something
    damps; without damping it is 0 or 180 degrees alone, and left out.
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
    phases: list[np.ndarray] = []
    for label, style, answer in curves:
        plain = {**style, "marker": "", "linewidth": 1.1}
        magnitude.plot(frequency, np.abs(answer), label=label, **plain)
        if damped:
            phases.append(_phase(answer))
            lowest.plot(frequency, phases[-1], **plain)
    for axes in sheet.axes:
        logarithmic(axes, "x", frequency[0], frequency[-1])
    low = min(np.nanmin(np.abs(answer)[np.abs(answer) > 0.0]) for *_, answer in curves if np.abs(answer).any())
    logarithmic(magnitude, "y", max(0.5 * low, DEPTH * height), 3.0 * height)
    unit = ds["frequency_response_real"]
    magnitude.set_ylabel(KIND.get(unit.attrs.get("units", ""), "Magnitude") + in_units(unit))
    if damped:
        ends = [int(np.round(reduce(phases) / RIGHT_ANGLE)) for reduce in (np.nanmin, np.nanmax)]
        turn = 1 if ends[1] - ends[0] < MANY else 2
        lowest.set(ylabel="Phase (degrees)", yticks=RIGHT_ANGLE * np.arange(ends[0], ends[1] + 1, turn))
    lowest.set_xlabel(axis_label(ds["response_frequency"]))
    force = ds["frequency_response_position"]
    where = f"force at ξ = {float(force):g}" if force.size == 1 else ""
    return sheet.finish(ds, (*drawn.notes, where, left))


def _phase(answer: np.ndarray) -> np.ndarray:
    """Phase in degrees without steps of 360 degrees, below 180: a displacement lags."""
    held = np.isfinite(answer)
    phase = np.full(answer.size, np.nan)
    phase[held] = np.degrees(np.unwrap(np.angle(answer[held])))
    return phase - 360.0 * np.ceil((np.nanmax(phase, initial=-np.inf) - END) / 360.0) if held.any() else phase


def _answer(case: xr.Dataset, point: int) -> np.ndarray:
    """Complex answer of one point."""
    return (case["frequency_response_real"][point] + 1j * case["frequency_response_imag"][point]).values
