"""One sensor's history, whatever file it comes from, and the arrays of which histories are cut."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

TIME_NAMES = ("time", "t")
RATE_NAMES = ("sample_rate", "sampling_rate", "samplerate", "fs", "sr")
INTERVAL_NAMES = ("dt", "delta_t", "interval")


class NotARecord(ValueError):
    """The file holds no histories, or does not say their times; the text says what would do."""


@dataclass
class Channel:
    """A history: its samples with what is known of them. Times are those of `times`, in s."""

    name: str
    values: np.ndarray  # (samples,), as the file has them
    times: np.ndarray  # (samples,)
    unit: str = ""  # as the file writes it
    quantity: str = ""  # displacement, velocity, acceleration, strain; empty where the file does not say
    description: str = ""
    position: float | None = None  # x/l


@dataclass
class Wanted:
    """What the caller says that a file may not: names of arrays, and the sampling rate in Hz."""

    sample_rate: float | None = None
    time: str | None = None  # the array of times
    variables: list[str] = field(
        default_factory=list
    )  # the arrays of histories; none: all that are as long as the time


def even_times(count: int, interval: float, start: float = 0.0) -> np.ndarray:
    """The times of `count` samples."""
    return start + np.arange(count) * interval


def channels_of(arrays: Mapping[str, np.ndarray], wanted: Wanted, source: str) -> list[Channel]:
    """Histories among the arrays of a file, named after them; of an array of several, `name_1`, `name_2` and so on.

    The time is the array that `wanted` names, or the one called time or t; else the sampling rate tells it, which
    `wanted` or a number called fs, dt and the like gives.
    """
    numbers = {name: array for name, array in arrays.items() if array.dtype.kind in "fiub" and array.size}
    time_name, times = _times(numbers, wanted, source)
    names = wanted.variables or [name for name in numbers if name != time_name]
    for name in names:
        if name not in numbers:
            raise NotARecord(f"no array of numbers called {name}; there: {', '.join(numbers) or 'none'}")
    long = {name: _columns(numbers[name], None if times is None else times.size) for name in names}
    long = {name: columns for name, columns in long.items() if columns is not None}
    if not wanted.variables and times is None and long:
        most = max(columns.shape[0] for columns in long.values())
        long = {name: columns for name, columns in long.items() if columns.shape[0] == most}
    left_out = [name for name in wanted.variables if name not in long]
    if left_out:
        raise NotARecord(f"{left_out[0]} is not as long as the time, {time_name}")
    if not long:
        raise NotARecord("no array of at least two samples" + (f" as long as {time_name}" if time_name else ""))
    interval = 0.0 if times is not None else 1.0 / _rate(numbers, wanted)
    found = []
    for name, columns in long.items():
        when = even_times(columns.shape[0], interval) if times is None else times
        for number, values in enumerate(columns.T, 1):
            found.append(Channel(name if columns.shape[1] == 1 else f"{name}_{number}", values, when))
    return found


def _times(numbers: Mapping[str, np.ndarray], wanted: Wanted, source: str) -> tuple[str, np.ndarray | None]:
    """Name and values of the time; none where the sampling rate tells it."""
    if wanted.time is not None:
        if wanted.time not in numbers:
            raise NotARecord(
                f"no array of numbers called {wanted.time} in {source}; there: {', '.join(numbers) or 'none'}"
            )
        return wanted.time, numbers[wanted.time].astype(float).ravel()
    if wanted.sample_rate is not None:
        return next(_named(numbers, TIME_NAMES), ""), None
    for name in _named(numbers, TIME_NAMES):
        if numbers[name].size > 1 and max(numbers[name].shape) == numbers[name].size:
            return name, numbers[name].astype(float).ravel()
    return "", None


def _rate(numbers: Mapping[str, np.ndarray], wanted: Wanted) -> float:
    """The sampling rate [Hz]: as the caller says, or a single number of the file."""
    if wanted.sample_rate is not None:
        return wanted.sample_rate
    for name in _named(numbers, RATE_NAMES):
        if numbers[name].size == 1 and float(numbers[name].ravel()[0]) > 0:
            return float(numbers[name].ravel()[0])
    for name in _named(numbers, INTERVAL_NAMES):
        if numbers[name].size == 1 and float(numbers[name].ravel()[0]) > 0:
            return 1.0 / float(numbers[name].ravel()[0])
    raise NotARecord("nothing tells the times; give --sample-rate, or --time with the name of their array")


def _named(numbers: Mapping[str, np.ndarray], names: Iterable[str]) -> Iterable[str]:
    """Arrays of some names, in whatever letters, also inside a structure: `run1.time`."""
    return (name for wanted in names for name in numbers if name.lower().rsplit(".", 1)[-1] == wanted)


def _columns(array: np.ndarray, samples: int | None) -> np.ndarray | None:
    """The histories of an array as columns, (samples, n): along the axis as long as the time, or the longer one."""
    array = np.squeeze(array)
    if array.ndim == 1:
        array = array[:, np.newaxis]
    if array.ndim != 2 or max(array.shape) < 2:
        return None
    if samples is not None:
        if array.shape[0] == samples:
            return array
        return array.T if array.shape[1] == samples else None
    return array if array.shape[0] >= array.shape[1] else array.T
