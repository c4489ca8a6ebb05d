"""The lines of a record: frequency, decay and amplitude, with their intervals, and what kind of line each is."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.curves import Curve, panels_of
from ..parts.select import Chosen, chosen
from ..parts.sensors import common_label, sensor_label, sensor_name, shown_sensors, status_words
from ..parts.sheet import Given, sheet_for
from ..result import require
from ..style import ABOVE_GRID, MARKERS, curve_style, logarithmic, styled

FREQUENCY, DECAY, AMPLITUDE = "measured_angular_frequency", "measured_decay_rate", "measured_amplitude"


@styled
def lines(ds: xr.Dataset, *, points: Chosen = None, cases: Chosen = None, ax: Given = None) -> Figure:
    """Amplitude and decay rate of the lines of a record over their frequency (Hz), above each other.

    Bars are the intervals of the file (`_error`) where it has them. In the lowest axes the marker tells the status of a
    line (one of a close pair, a harmonic, drifting, …), and in the upper ones the sensor; of several cases it tells the case, and each
    sensor has axes of its own.
    """
    ds = chosen(ds, points=points, cases=cases)
    require(ds, FREQUENCY, DECAY)
    drawn = panels_of(ds, FREQUENCY, panels=1)
    several = len(drawn.curves) > 1
    every = list(range(ds.sizes["point"])) if AMPLITUDE in ds and "point" in ds[AMPLITUDE].dims else []
    sensors, left = shown_sensors(ds) if several and every else (every, "")
    groups = [[sensor] for sensor in sensors] if several and every else [every]
    sheet = sheet_for(ax, len(groups) + 1, 1, height=2.7 if len(groups) == 1 else 2.1, share="x")
    *above, below = sheet.axes
    for axes, group in zip(above, groups):
        _draw_sensors(axes, ds, drawn.curves, group, own=sheet.own)
    for curve in drawn.curves:
        _draw_decay(below, curve, by_status=not several)
    below.axhline(0.0, color="0.5", linewidth=0.8, zorder=ABOVE_GRID)
    below.set(xlabel="Frequency (Hz)", ylabel="Decay rate (1/s)")
    notes = ["bars: intervals" if f"{FREQUENCY}_error" in ds else "", left]
    return sheet.finish(ds, [*drawn.notes, *notes, "negative decay rates grow" if float(ds[DECAY].min()) < 0.0 else ""])


def _draw_sensors(axes: Axes, ds: xr.Dataset, curves: list[Curve], sensors: list[int], *, own: bool) -> None:
    """Amplitudes of all cases at these sensors."""
    sizes = [size for curve in curves for size in _draw_amplitudes(axes, curve, len(curves), sensors)]
    if sizes:
        logarithmic(axes, "y", 0.4 * min(sizes), 2.5 * max(sizes))
        if len(curves) > 1:
            axes.set_ylabel(sensor_label(ds, sensors[0]))
        else:
            axes.set_ylabel(common_label(ds, AMPLITUDE, "Amplitude"))
    elif own:
        axes.set_visible(False)


def _draw_amplitudes(axes: Axes, curve: Curve, cases: int, sensors: list[int]) -> list[float]:
    """Stems of the amplitudes at these sensors; those drawn."""
    case, found = curve.data, []
    for point in sensors:
        frequency, size, bar = (_values(case, name, point) for name in (FREQUENCY, AMPLITUDE, f"{AMPLITUDE}_error"))
        known = np.isfinite(frequency) & (size > 0.0)
        style = curve_style(point) if cases == 1 else curve.style
        label = sensor_name(case, point) if cases == 1 else curve.label
        if cases == 1 and case.sizes["point"] == 1:
            label = None  # nothing to tell it from
        axes.vlines(
            frequency[known] / (2 * np.pi),
            np.finfo(float).tiny,
            size[known],
            color=style["color"],
            linewidth=0.5,
            alpha=0.5,
        )
        axes.errorbar(
            frequency[known] / (2 * np.pi),
            size[known],
            _bars(bar, known),
            capsize=2,
            label=label,
            **{**style, "linestyle": ""},
        )
        found += list(size[known])
    return found


def _draw_decay(axes: Axes, curve: Curve, *, by_status: bool) -> None:
    """Decay rates with the intervals of both numbers; the marker is that of the curve or of the line's status."""
    case = curve.data
    frequency, decay = _values(case, FREQUENCY), _values(case, DECAY)
    told = by_status and "peak_status" in case
    status = case["peak_status"].values if told else np.ones(frequency.size)
    kinds = np.unique(status[np.isfinite(frequency)])
    for number, value in enumerate(kinds):
        mine = np.isfinite(frequency) & np.isfinite(decay) & (status == value)
        across, along = (_bars(_values(case, f"{name}_error"), mine) for name in (FREQUENCY, DECAY))
        words = status_words(case["peak_status"], int(value)) if told else "line"
        plain = words == "line" and kinds.size == 1  # nothing to tell it from
        style = {**curve.style, "linestyle": ""} | ({"marker": MARKERS[number % len(MARKERS)]} if told else {})
        label = None if plain else words
        axes.errorbar(
            frequency[mine] / (2 * np.pi),
            decay[mine],
            along,
            None if across is None else across / (2 * np.pi),
            capsize=2,
            label=label,
            **style,
        )


def _values(case: xr.Dataset, name: str, point: int = 0) -> np.ndarray:
    """Values by peak, of one point where the variable tells points apart; NaN where the file lacks it."""
    if name not in case:
        return np.full(case.sizes["peak"], np.nan)
    return case[name].values[point] if "point" in case[name].dims else case[name].values


def _bars(values: np.ndarray, known: np.ndarray) -> np.ndarray | None:
    """Half-widths of intervals; none where not one is known."""
    return np.nan_to_num(values[known]) if np.isfinite(values).any() else None
