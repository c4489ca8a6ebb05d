"""A record and what its lines make of it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.envelope import is_dense, is_thinned
from ..parts.sensors import one_record, sensor_label, shown_sensors
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, styled

PERIODS = 15.0  # that are seen from near, of the fastest line that is at least …
STRONG = 0.2  # … this part as strong as the strongest
SINGLE = 250  # samples up to which each is drawn
PART = 0.25  # of the record, at most, that is seen from near
LEAST = 60  # samples there, at least
SEEN = {"color": GREY, "linewidth": 1.8, "label": "record"}
FITTED = {"color": COLOURS[2], "linewidth": 0.9, "label": "its lines"}
LEFT = {"color": COLOURS[1], "linewidth": 0.6, "label": "what they leave"}


@styled
def record_fit(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw `recorded` and `fitted` (point, time): the whole record, and beside it the beginning of its decay from near.

    Of a sweep the first case is drawn. What was thinned in the file is drawn as the band between the least and the
    largest value of each stretch, and has no second column.
    """
    case, note = one_record(ds)
    require(case, "recorded", "fitted", "time")
    time = case["time"].values
    recorded, fitted = case["recorded"].values, case["fitted"].values
    known = np.isfinite(recorded).any(axis=0)
    if np.count_nonzero(known) < 2:
        raise NothingToDraw("the record is not in the file")
    time, recorded, fitted = time[known], recorded[:, known], fitted[:, known]
    sensors, left = shown_sensors(case)
    thin = is_thinned(recorded)
    near = None if thin else _near(case, time)
    sheet = sheet_for(ax, len(sensors), 1 if near is None else 2, width=6.8 if near is None else 9.6, height=2.3, share="x")
    for row, sensor in zip(sheet.grid, sensors):
        _draw_whole(row[0], time, recorded[sensor], fitted[sensor], thin)
        row[0].set_ylabel(sensor_label(case, sensor))
        if near is not None:
            _draw_near(row[1], time[near], recorded[sensor, near], fitted[sensor, near])
    for axes in sheet.grid[-1]:
        axes.set_xlabel("Time since the first sample (s)")
    words = "bands: least to largest of each stretch of time" if thin else ""
    return sheet.finish(case, [note, left, words])


def _draw_whole(axes: Axes, time: np.ndarray, recorded: np.ndarray, fitted: np.ndarray, thin: bool) -> None:
    """The record and its fit as lines, or as bands where lines would fill the picture."""
    axes.set_xlim(time[0], time[-1])
    if thin:
        middle = 0.5 * (time[::2] + time[1::2])
        _draw_band(axes, middle, recorded[::2], recorded[1::2], SEEN)
        _draw_band(axes, middle, fitted[::2], fitted[1::2], FITTED)
        return
    dense = is_dense(recorded)
    for values, style in ((recorded, SEEN), (fitted, FITTED), (recorded - fitted, LEFT)):
        if dense:
            _draw_band(axes, *_extremes(time, values), style)
        else:
            axes.plot(time, values, **style)


def _draw_near(axes: Axes, time: np.ndarray, recorded: np.ndarray, fitted: np.ndarray) -> None:
    """Samples one by one, where they are few, on the line of the fit."""
    few = {"linestyle": "", "marker": ".", "markersize": 5.0} if time.size <= SINGLE else {}
    axes.plot(time, recorded, **{**SEEN, **few, "label": None})
    axes.plot(time, fitted, **{**FITTED, "label": None})
    axes.set_xlim(time[0], time[-1])


def _draw_band(axes: Axes, time: np.ndarray, low: np.ndarray, high: np.ndarray, style: dict) -> None:
    """From the least to the largest value."""
    axes.fill_between(time, low, high, color=style["color"], alpha=0.45, linewidth=0.6, label=style["label"])


def _extremes(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle, least and largest of some hundred stretches."""
    edges = np.linspace(0, values.size - 1, 401).round().astype(int)
    parts = [slice(start, end + 1) for start, end in zip(edges, edges[1:])]
    return (
        np.array([time[part].mean() for part in parts]),
        np.array([values[part].min() for part in parts]),
        np.array([values[part].max() for part in parts]),
    )


def _near(case: xr.Dataset, time: np.ndarray) -> slice | None:
    """Samples of some periods of the fastest of the strong lines from the blow on; none where that is most of the record."""
    strength = np.nan_to_num(case["measured_amplitude"].values).max(axis=0)
    if not strength.any():
        return None
    beta = case["measured_angular_frequency"].values[strength >= STRONG * strength.max()].max()
    blow = float(case["measured_blow_time"]) if "measured_blow_time" in case else time[0]
    first = int(np.searchsorted(time, blow)) if np.isfinite(blow) else 0
    end = time[first] + min(PERIODS * 2.0 * np.pi / beta, PART * (time[-1] - time[0]))
    count = max(int(np.searchsorted(time, end)) - first, LEAST)
    return slice(first, first + count) if count < 0.5 * time.size and first + count <= time.size else None
