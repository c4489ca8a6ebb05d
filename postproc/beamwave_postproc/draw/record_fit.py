"""A record and what its lines make of it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..parts.envelope import broken_at_gaps, is_dense, is_thinned, recorded_part
from ..parts.sensors import one_record, sensor_label, shown_sensors
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import ABOVE_GRID, COLOURS, GREY, styled

PERIODS = 15.0  # that are seen from near, of the fastest line that is at least …
STRONG = 0.2  # … this part as strong as the strongest
SINGLE = 250  # samples up to which each is drawn
PART = 0.25  # of the record, at most, that is seen from near
LEAST = 60  # samples there, at least
RATIOS = [3.0, 1.3]  # of the heights of a record and its residual
FINE = 12  # times as many places as samples, at which the sum of the lines is drawn from near
SAME = 0.01  # of the largest value: so near is that sum to the fit of the file at its samples
SEEN = {"color": GREY, "linewidth": 1.8, "label": "record"}
FITTED = {"color": COLOURS[2], "linewidth": 0.9, "label": "fit: sum of its lines"}
RESIDUAL = {"color": COLOURS[1], "linewidth": 0.6, "label": "residual: record − fit"}


@styled
def record_fit(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw `recorded` and `fitted` (point, time): the whole record, and beside it the beginning of its decay from near.

    Below each stands the residual, on a scale of its own. From near the fit is drawn between the samples, too, as the sum of the lines.
    Of a sweep the first case is drawn. What was thinned in the file is drawn as the band between the least and the
    largest value of each stretch, and has neither residual nor second column.
    """
    case, note = one_record(ds)
    require(case, "recorded", "fitted", "time")
    time = case["time"].values
    recorded, fitted = case["recorded"].values, case["fitted"].values
    part = recorded_part(recorded)
    if part.stop < 2:
        raise NothingToDraw("the record is not in the file")
    time, recorded, fitted = time[part], recorded[:, part], fitted[:, part]
    sensors, left = shown_sensors(case)
    thin = is_thinned(recorded)
    if not thin:
        time, recorded, fitted = broken_at_gaps(time, recorded, fitted)
    out = "gaps: samples that are missing or left out" if np.isnan(recorded[sensors]).any() else ""
    blow = float(case["measured_blow_time"].fillna(time[0])) if "measured_blow_time" in case else time[0]
    near = None if thin else _near(case, time, blow)
    rows, ratios = (1, [1.0]) if thin else (2, RATIOS)
    columns, width, height = (1, 6.8, 2.3) if near is None else (2, 9.6, 2.3)
    size = {"width": width, "height": height if thin else 0.65 * height, "ratios": ratios * len(sensors)}
    sheet = sheet_for(ax, rows * len(sensors), columns, share="x", **size)
    for above, below, sensor in zip(sheet.grid[::rows], sheet.grid[rows - 1 :: rows], sensors):
        _draw_whole(above[0], time, recorded[sensor], fitted[sensor], thin)
        above[0].set_ylabel(sensor_label(case, sensor))
        if near is not None:
            _draw_near(above[1], case, sensor, time[near], recorded[sensor, near], fitted[sensor, near])
        if not thin:
            below[0].set_ylabel(f"Residual\n{_unit(case, sensor)}")
            _draw_residual(below, time, np.where(time < blow, np.nan, recorded[sensor] - fitted[sensor]), near)
    for axes in sheet.grid[-1]:
        axes.set_xlabel("Time since the first sample (s)")
    words = "bands: least to largest of each stretch of time" if thin else ""
    return sheet.finish(case, [note, left, words, out])


def _draw_whole(axes: Axes, time: np.ndarray, recorded: np.ndarray, fitted: np.ndarray, thin: bool) -> None:
    """The record and its fit as lines, or as bands where lines would fill the picture."""
    axes.set_xlim(time[0], time[-1])
    if thin:
        middle = 0.5 * (time[::2] + time[1::2])
        _draw_band(axes, middle, recorded[::2], recorded[1::2], SEEN)
        _draw_band(axes, middle, fitted[::2], fitted[1::2], FITTED)
        return
    dense = is_dense(recorded)
    for values, style in ((recorded, SEEN), (fitted, FITTED)):
        if dense:
            _draw_band(axes, *_extremes(time, values), style)
        else:
            axes.plot(time, values, **style)


def _draw_near(
    axes: Axes, case: xr.Dataset, sensor: int, time: np.ndarray, recorded: np.ndarray, fitted: np.ndarray
) -> None:
    """Samples one by one, where they are few, on the line of the fit."""
    few = {"linestyle": "", "marker": ".", "markersize": 5.0, "zorder": 3} if time.size <= SINGLE else {}
    axes.plot(time, recorded, **{**SEEN, **few, "label": None})
    axes.plot(*(_between_samples(case, sensor, time, fitted) or (time, fitted)), **{**FITTED, "label": None})
    axes.set_xlim(time[0], time[-1])
    axes.xaxis.set_major_locator(MaxNLocator(5))


def _between_samples(
    case: xr.Dataset, sensor: int, time: np.ndarray, fitted: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Fine times and the sum of the lines there; None where that is not the fit of the file at its samples."""
    names = ("angular_frequency", "decay_rate", "amplitude", "phase")
    if any(f"measured_{name}" not in case for name in names):
        return None
    beta, decay, size, phase = (case[f"measured_{name}"].values for name in names)
    known = np.isfinite(beta)
    factor = size[sensor, known] * np.exp(1j * phase[sensor, known])

    def lines(at: np.ndarray) -> np.ndarray:
        return np.real(np.exp(at[:, None] * (1j * beta[known] - decay[known])) @ factor)

    if np.nanmax(np.abs(lines(time) - fitted)) > SAME * np.nanmax(np.abs(fitted)):
        return None
    fine = np.linspace(time[0], time[-1], FINE * time.size)
    return fine, lines(fine)


def _draw_residual(row: list[Axes], time: np.ndarray, residual: np.ndarray, near: slice | None) -> None:
    """What the fit leaves of one record from the blow on, whole and from near, on one scale."""
    style, largest = dict(RESIDUAL), 1.15 * np.nanmax(np.abs(residual)) or 1.0
    if is_dense(residual):
        _draw_band(row[0], *_extremes(time, residual), style)
    else:
        row[0].plot(time, residual, **style)
    if near is not None:
        few = {"linestyle": "", "marker": ".", "markersize": 4.0} if time[near].size <= SINGLE else {}
        row[1].plot(time[near], residual[near], **{**style, **few, "label": None})
    for axes in row:
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=ABOVE_GRID)
        axes.set_ylim(-largest, largest)


def _unit(case: xr.Dataset, sensor: int) -> str:
    """Unit of a sensor in brackets."""
    return "(" + sensor_label(case, sensor).rpartition("(")[2] if "(" in sensor_label(case, sensor) else ""


def _draw_band(axes: Axes, time: np.ndarray, low: np.ndarray, high: np.ndarray, style: dict) -> None:
    """From the least to the largest value."""
    axes.fill_between(time, low, high, color=style["color"], alpha=0.45, linewidth=0.6, label=style["label"])


def _extremes(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle, least and largest of some hundred stretches of time; no values where there are no samples."""
    edges = np.linspace(time[0], time[-1], 401)
    places = np.searchsorted(time, edges)
    parts = [values[start : end + 1] if end > start else [np.nan] for start, end in zip(places, places[1:])]
    return (
        0.5 * (edges[1:] + edges[:-1]),
        np.array([np.fmin.reduce(part) for part in parts]),
        np.array([np.fmax.reduce(part) for part in parts]),
    )


def _near(case: xr.Dataset, time: np.ndarray, blow: float) -> slice | None:
    """Samples of some periods of the fastest of the strong lines from the blow on; none where that is most of the record."""
    strength = np.nan_to_num(case["measured_amplitude"].values).max(axis=0)
    if not strength.any():
        return None
    beta = case["measured_angular_frequency"].values[strength >= STRONG * strength.max()].max()
    first = int(np.searchsorted(time, blow))
    end = time[first] + min(PERIODS * 2.0 * np.pi / beta, PART * (time[-1] - time[0]))
    count = max(int(np.searchsorted(time, end)) - first, LEAST)
    return slice(first, first + count) if count < 0.5 * time.size and first + count <= time.size else None
