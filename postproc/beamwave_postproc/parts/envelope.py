"""Long histories that would be a blob as a line: the band between smallest and largest number of each interval."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes

INTERVALS = 600  # about as many as a picture has columns to tell apart
CROSSED = (
    3.0  # times that a line runs through its own range in an interval, from where on nothing but the range is seen
)
GAP = 4.0  # median steps between two samples, from where on some are missing
SEEN = 0.02  # of the whole range: what moves less in an interval is a thin line anyhow


def is_dense(values: np.ndarray) -> bool:
    """Whether a history (time) as a line would fill the area between its extremes."""
    if values.size < 4 * INTERVALS:
        return False
    parts = [part for part in _parts(values) if np.isfinite(part).any()]
    ways = np.array([np.nansum(np.abs(np.diff(part))) for part in parts])
    ranges = np.array([np.nanmax(part) - np.nanmin(part) for part in parts])
    whole = np.nanmax(values) - np.nanmin(values) if parts else 0.0
    return bool(parts) and bool(ranges.mean() > SEEN * whole and ways.sum() > CROSSED * ranges.sum())


def draw_envelope(axes: Axes, time: np.ndarray, values: np.ndarray, *, colour: str) -> str:
    """Draw smallest to largest number of each interval as a band, their means as a line; what that is, in words."""
    parts, times = _parts(values), _parts(time)
    middle = np.array([part.mean() for part in times])
    low, high, mean = (np.array([reduce(part) for part in parts]) for reduce in (np.min, np.max, np.mean))
    axes.fill_between(middle, low, high, color=colour, alpha=0.35, linewidth=0.0)
    axes.plot(middle, mean, color=colour, linewidth=0.8)
    return f"band: smallest to largest in each of {len(parts)} intervals; line: their mean"


def largest_of_each(rows_of: Callable[[slice], np.ndarray], samples: int, columns: int, block: int) -> np.ndarray:
    """Image (row, column) of at most so many `columns`, each the number of largest magnitude, with its sign, of its share of the samples.

    `rows_of` gives the numbers (row, sample) of a part of the samples; about a `block` of them is asked for at once.
    """
    edges = np.linspace(0, samples, min(columns, samples) + 1).round().astype(int)
    found = []
    for group in np.array_split(np.arange(edges.size - 1), max(1, samples // block)):
        first, last = edges[group[0]], edges[group[-1] + 1]
        values = rows_of(slice(first, last))
        high, low = (reduce.reduceat(values, edges[group] - first, axis=1) for reduce in (np.maximum, np.minimum))
        found.append(np.where(high >= -low, high, low))
    return np.hstack(found)


def _parts(values: np.ndarray) -> list[np.ndarray]:
    """Cut into intervals of nearly one length, each with the first number of the next, so that steps between count."""
    edges = np.linspace(0, values.size - 1, INTERVALS + 1).round().astype(int)
    return [values[start : end + 1] for start, end in zip(edges, edges[1:])]


def is_thinned(recorded: np.ndarray) -> bool:
    """Whether all known values stand in pairs, the least before the largest."""
    if recorded.shape[1] % 2:
        return False
    return not bool((recorded[:, ::2] > recorded[:, 1::2]).any())


def recorded_part(recorded: np.ndarray) -> slice:
    """The times up to the last sample of any sensor: the record of another case may be longer."""
    known = np.flatnonzero(np.isfinite(recorded).any(axis=0))
    return slice(0, known[-1] + 1 if known.size else 0)


def broken_at_gaps(time: np.ndarray, *histories: np.ndarray) -> list[np.ndarray]:
    """Times and histories (sensor, time) with a missing sample in the middle of each gap, so that no line is drawn across it."""
    steps = np.diff(time)
    gaps = np.flatnonzero(steps > GAP * np.median(steps)) if steps.size else []
    middle = [0.5 * (time[gap] + time[gap + 1]) for gap in gaps]
    places = np.asarray(gaps, dtype=int) + 1
    return [np.insert(time, places, middle), *(np.insert(values, places, np.nan, axis=-1) for values in histories)]
