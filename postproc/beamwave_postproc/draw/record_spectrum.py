"""The spectrum of a record: its noise, its lines, and what else was looked at."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.labels import flag_words
from ..parts.sensors import one_record, sensor_label, shown_sensors, status_words
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, MARKERS, logarithmic, styled

BELOW = 0.2  # of the lowest noise level, to which the axis goes down
REJECTED = {"color": COLOURS[4], "linestyle": "", "marker": "x", "markersize": 6.0, "markeredgewidth": 1.4}


@styled
def record_spectrum(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw `amplitude` and `noise_level` (point, frequency) with the lines found and the candidates rejected.

    The marker tells what a line is: one of a close pair, a harmonic, drifting. Crosses are places that were looked at and
    are no lines, but for those at a line, where no second one is; the head counts all by their reasons. Of a sweep the first
    case is drawn.
    """
    case, note = one_record(ds)
    require(case, "amplitude", "noise_level", "frequency", "measured_angular_frequency")
    frequency = case["frequency"].values
    if np.count_nonzero(np.isfinite(case["amplitude"].values).any(axis=0)) < 3:
        raise NothingToDraw("the spectrum is not in the file")
    sensors, left = shown_sensors(case)
    sheet = sheet_for(ax, len(sensors), 1, width=7.6, height=3.2 if len(sensors) == 1 else 2.5, share="x")
    for axes, sensor in zip(sheet.axes, sensors):
        _draw_sensor(axes, case, frequency, sensor)
        axes.set_ylabel(sensor_label(case, sensor))
    sheet.axes[-1].set_xlabel("Frequency (Hz)")
    return sheet.finish(case, [note, left, _reasons(case)])


def _draw_sensor(axes: Axes, case: xr.Dataset, frequency: np.ndarray, sensor: int) -> None:
    """One sensor's spectrum from its second frequency on."""
    amplitude, noise = case["amplitude"].values[sensor], case["noise_level"].values[sensor]
    shown = (frequency > 0.0) & np.isfinite(amplitude)
    axes.plot(frequency[shown], amplitude[shown], color=GREY, linewidth=0.8, label="record")
    axes.plot(frequency[shown], noise[shown], color=COLOURS[1], linewidth=1.3, label="noise, root mean square")
    floor = np.nanmin(noise[shown]) if np.isfinite(noise[shown]).any() else 0.0
    peak = np.nanmax(amplitude[shown])
    logarithmic(axes, "y", max(BELOW * floor, 1e-9 * peak), 3.0 * peak)
    axes.set_xlim(0.0, frequency[shown][-1])
    _mark_lines(axes, case, frequency, amplitude)
    rejected = case["candidate_angular_frequency"].values / (2.0 * np.pi) if "candidate_angular_frequency" in case else []
    rejected = np.array([place for place in rejected if np.isfinite(place) and place <= frequency[shown][-1]])
    found = case["measured_angular_frequency"].values / (2.0 * np.pi)
    if found.size and rejected.size:
        away = np.abs(rejected[:, None] - np.where(np.isfinite(found), found, np.inf)).min(axis=1)
        rejected = rejected[away > 1.5 * (frequency[1] - frequency[0])]
    if rejected.size:
        axes.plot(rejected, _height(frequency, amplitude, rejected), label="rejected candidate", **REJECTED)


def _mark_lines(axes: Axes, case: xr.Dataset, frequency: np.ndarray, amplitude: np.ndarray) -> None:
    """A marker on the spectrum for each line, by what it is."""
    places = case["measured_angular_frequency"].values / (2.0 * np.pi)
    known = np.isfinite(places)
    status = case["peak_status"].values if "peak_status" in case else np.ones(places.size, int)
    for number, value in enumerate(np.unique(status[known])):
        mine = known & (status == value)
        words = status_words(case["peak_status"], int(value)) if "peak_status" in case else "line"
        axes.plot(
            places[mine],
            _height(frequency, amplitude, places[mine]),
            linestyle="",
            marker=MARKERS[number % len(MARKERS)],
            color=COLOURS[2],
            markerfacecolor="white",
            markeredgewidth=1.2,
            label=words or "line",
        )


def _height(frequency: np.ndarray, amplitude: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The largest amplitude at each place and one frequency to either side."""
    nearest = np.searchsorted(0.5 * (frequency[1:] + frequency[:-1]), places)
    around = np.clip(nearest[:, None] + np.array([-1, 0, 1]), 0, frequency.size - 1)
    return np.nanmax(np.nan_to_num(amplitude)[around], axis=1)


def _reasons(case: xr.Dataset) -> str:
    """How many candidates were rejected, by reason."""
    if "candidate_reason" not in case or "candidate_count" not in case or not int(case["candidate_count"]):
        return ""
    words = flag_words(case["candidate_reason"])
    reasons, counts = np.unique(case["candidate_reason"].values[case["candidate_reason"].values > 0], return_counts=True)
    told = [f"{count} {words.get(int(reason), '').replace('_', ' ')}" for reason, count in zip(reasons, counts)]
    return f"rejected candidates: {', '.join(told)}"
