"""A history over time and frequency, with the times at which its waves arrive."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.events import ROW, mark_events
from ..parts.growth import grows
from ..parts.labels import axis_label
from ..parts.level import decibels, draw_level, highest_in_rows
from ..parts.moving import folded_frequencies, folding_note
from ..parts.passage import MOST, arrivals, highest_frequency, way_times
from ..parts.points import error_warning
from ..parts.select import Chosen, chosen, one_case
from ..parts.sheet import Given, columns_for, sheet_for
from ..parts.units import si_prefix, units_of, with_unit
from ..result import NothingToDraw, require, require_numbers
from ..style import COLOURS, ON_IMAGE, styled

RANGE, RANGE_OF_ARRIVALS = 80.0, 30.0  # decibels below the highest amplitude that are shown
WINDOWS = 14  # of what is shown in a window's length
SLICES = 400  # at most, of time
LEAST_SAMPLES, LEAST_WAVES = 64, 4
ROOM = 1.1  # above the highest mode
FINER = 2  # times as many frequencies as the window resolves
WAYS = 3  # from the blow to the point: straight, and by reflections
MIDPOINT = 0.5
# Beside lines that are aliased.
FOLDED: dict[str, Any] = {"linestyle": "", "marker": "<", "markersize": 4.0, "color": COLOURS[2]}


@styled
def spectrogram(
    ds: xr.Dataset, point: float | None = None, *, window: float | None = None, cases: Chosen = None, ax: Given = None
) -> Figure:
    """Amplitude (dB) of the acceleration of the first case at `point` (ξ) over time and frequency.

    Left the start of the record, each frequency over its own highest amplitude, with the times at which its waves
    arrive from the blow at the group velocity, straight and by reflections; right the whole record. The left one alone
    is drawn where the record is no longer, and on a given `ax`; the right one alone where the samples are too coarse
    for arrivals. The point is the one nearest the middle unless told, the acceleration the second difference of the
    displacement, and `window` the length (s) of Hann's window.
    """
    require(ds, "displacement", "time", "point_position")
    if point is None:
        positions = np.atleast_1d(ds["point_position"].values)
        point = float(positions[np.abs(positions - MIDPOINT).argmin()])
    case, note = one_case(chosen(ds, points=point, cases=cases))
    _require_motion(case)
    end, duration = arrivals(case), float(case["time"][-1])
    parts = [(duration, False)] if end is None else [(end, True)]
    if ax is None and end is not None and end < MOST * duration:
        parts.append((duration, False))
    if highest(case) * duration < WINDOWS * LEAST_WAVES:
        raise NothingToDraw(
            f"its windows, 1/{WINDOWS} of the record, hold fewer than {LEAST_WAVES} waves of any frequency"
        )
    columns = columns_for(len(parts))
    sheet = sheet_for(ax, len(parts) // columns, columns, width=6.4 if len(parts) == 1 else 9.6, height=3.8)
    for axes, (until, arriving) in zip(sheet.axes, parts):
        _draw(axes, case, until, window or until / WINDOWS, arriving)
    folding = folding_note([case], "a triangle at the right" if (duration, False) in parts else "")
    said = [note, rf"acceleration at $\xi$ = {point:.4g}", folding]
    return sheet.finish(ds, said, warning=error_warning([case], "displacement"))


def _require_motion(case: xr.Dataset) -> None:
    """Raise `NothingToDraw` unless the history moves, does not grow, and is long enough."""
    history = case["displacement"].values[0]
    require_numbers(history, "displacement")
    if grows(case) or not np.isfinite(history).all() or not history.any():
        raise NothingToDraw("a motion that grows or rests has no spectrogram worth a picture")
    if history.size < LEAST_SAMPLES:
        raise NothingToDraw(f"{history.size} samples are too few for a spectrogram")


def highest(case: xr.Dataset) -> float:
    """Highest frequency (Hz) of a history, with room above that of the modes; of a record that of its samples."""
    nyquist = 0.5 / float(case["time"][1] - case["time"][0])
    return min(ROOM * highest_frequency(case), nyquist) if "angular_frequency" in case else nyquist


def _draw(axes: Axes, case: xr.Dataset, until: float, window: float, arriving: bool) -> None:
    """The spectrogram up to `until` (s), with the arrivals or without."""
    step = float(case["time"][1] - case["time"][0])
    level, frequency, moments = levels(case["displacement"].values[0], step, window, until, each=arriving)
    clock, ticks = si_prefix(np.array([until]), units_of(case["time"]))
    top = min(highest_frequency(case) if arriving else highest(case), frequency[-1])
    prefix, factor = si_prefix(np.array([top]), "Hz")
    extent = (ticks * moments[0], ticks * moments[-1], 0.0, factor * frequency[-1])
    depth, words = (RANGE_OF_ARRIVALS, " of each frequency") if arriving else (RANGE, "")
    draw_level(axes, level, extent, depth, f"dB, 0 = the highest{words}")
    axes.set(xlim=(0.0, ticks * moments[-1]), ylim=(0.0, factor * top))
    axes.set(xlabel=axis_label(case["time"], clock), ylabel=f"Frequency ({prefix}Hz)")
    if arriving:
        _draw_arrivals(axes, case, ticks, factor, 1.0 / window)
    else:
        _mark_folded(axes, factor * folded_frequencies(case), ticks * moments[-1])
    rows = mark_events(axes, [case], ticks, words=True)
    axes.set_title(f"window of {with_unit(window, 's', 2)}", pad=6.0 + ROW * rows)


def levels(
    history: np.ndarray, step: float, window: float, until: float, *, each: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Amplitudes (frequency, time) of the acceleration in decibels, frequencies (Hz) and times (s) up to `until`.

    They are over the highest of all, or of `each` frequency; what the first window holds of the blow does not count.
    Before the record the beam is at rest, and so it is taken.
    """
    samples = min(max(round(window / step), 8), history.size)
    last = min(history.size, int(until / step) + samples)
    acceleration = np.diff(history[:last], n=2, prepend=(0.0, 0.0))
    hop = max(int(until / step) // SLICES, 1)
    moments = step * np.arange(0, last, hop)
    moments = moments[moments <= min(until, (last - samples / 2) * step)]
    frequency = np.fft.rfftfreq(FINER * samples, step)
    frequency, amplitude = highest_in_rows(frequency, short_transform(acceleration, samples, hop)[:, : moments.size])
    after = amplitude[:, moments >= min(window, 0.5 * until)]
    over = after.max(axis=1, keepdims=True) if each else after.max(keepdims=True)
    return decibels(amplitude, over), frequency, moments


def short_transform(values: np.ndarray, samples: int, hop: int) -> np.ndarray:
    """Magnitudes (frequency, time) of the transform under Hann's window of so many samples, about each `hop`-th value.

    Beyond the ends the values are taken as 0. A sine of amplitude A in the middle of a bin reads A/2.
    """
    window = np.hanning(samples + 1)[:-1]
    padded = np.pad(values, (samples // 2, samples))
    parts = np.lib.stride_tricks.sliding_window_view(padded, samples)[: values.size : hop]
    window /= window.sum()
    return np.array([np.abs(np.fft.rfft(part * window, FINER * samples)) for part in parts]).T


def _draw_arrivals(axes: Axes, case: xr.Dataset, ticks: float, factor: float, lowest: float) -> None:
    """Times and frequencies of the waves of the shortest ways: lines where they obey Eq. 2, else marks of modes.

    Below the `lowest` (Hz), of which a window holds not one wave, the picture shows no arrival, and none is drawn.
    """
    frequency, ways, smooth = way_times(case, float(case["point_position"][0]), WAYS)
    shown = frequency >= lowest
    for number, times in enumerate(ways):
        label = "arrivals at the group velocity: straight, then by reflections" if number == 0 else None
        style = {"linestyle": "-"} if smooth else {"linestyle": "", "marker": "o", "markersize": 3}
        axes.plot(ticks * times[shown], factor * frequency[shown], linewidth=1.2, label=label, **ON_IMAGE, **style)


def _mark_folded(axes: Axes, places: np.ndarray, end: float) -> None:
    """Marks at the right `end` of the axes; an empty line beyond its axes would spoil the layout."""
    if places.size:
        axes.plot(np.full(places.size, end), places, clip_on=False, **FOLDED)
