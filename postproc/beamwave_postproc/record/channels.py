"""One sensor's history, whatever file it comes from, and the arrays of which histories are cut."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from types import ModuleType

import numpy as np

from ..terminal import Refusal

TIME_NAMES = ("time", "t")
RATE_NAMES = ("sample_rate", "sampling_rate", "samplerate", "fs", "sr")
INTERVAL_NAMES = ("dt", "delta_t", "interval")


class NotARecord(Refusal):
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
    record: str = ""  # what it is part of, where a file holds several records
    line: int = 0  # of its first sample in a text


@dataclass
class Wanted:
    """What the caller says that a file may not: names of arrays, the sampling rate in Hz, the order of dates."""

    sample_rate: float | None = None
    time: str | None = None  # the array of times, or the number of a column or a cell, from 1
    variables: list[str] = field(
        default_factory=list
    )  # the arrays of histories; none: all that are as long as the time
    time_scale: float = 1.0  # s over the file's unit of time
    date_order: str | None = None  # day or month, whichever is first in dates whose year is last


def needed(module: str, files: str) -> ModuleType:
    """A module that only some files need; raises `NotARecord` where it is not installed."""
    try:
        return import_module(module)
    except ImportError as missing:
        raise NotARecord(
            f"reading {files} takes the Python package {module}: pip install './postproc[records]'"
        ) from missing


def refuse_inconsistent(channel: Channel) -> None:
    """Raise `NotARecord` where times do not rise, or a value is infinite, naming its line or row."""

    def place(number: int) -> str:
        return f"line {channel.line + number}" if channel.line else f"row {number + 1}"

    times = channel.times
    if (falls := np.flatnonzero(~(np.diff(times) > 0.0))).size:
        after = int(falls[0]) + 1
        raise NotARecord(
            f"{place(after)}: the time is {times[after]:g} s after {times[after - 1]:g} s; accepted: times that rise, or --sample-rate"
        )
    if (wrong := np.flatnonzero(np.isinf(channel.values))).size:
        raise NotARecord(f"{place(int(wrong[0]))}: {channel.name} is infinite; accepted: numbers")


def own_times(times: np.ndarray, wanted: Wanted, clock: str) -> np.ndarray:
    """The times that a file has, or by the caller's sampling rate where they do not rise, as clocks of whole seconds.

    Raises `NotARecord` where he gives one and they do.
    """
    if wanted.sample_rate is None:
        return times
    if (np.diff(times) > 0.0).all():
        raise NotARecord(f"has times of its own, {clock}; accepted: without --sample-rate")
    return even_times(times.size, 1.0 / wanted.sample_rate)


def even_times(count: int, interval: float, start: float = 0.0) -> np.ndarray:
    """The times of `count` samples; raises `NotARecord` for an interval that is none."""
    if not (0.0 < interval < np.inf and np.isfinite(start)):
        raise NotARecord(f"the interval between samples is {interval:g} s, from {start:g} s on; accepted: above 0")
    return start + np.arange(count) * interval


def channels_of(arrays: Mapping[str, np.ndarray], wanted: Wanted, source: str) -> list[Channel]:
    """Histories among the arrays of a file, named after them; of an array of several, `name_1`, `name_2` and so on.

    The time is the array that `wanted` names, or the one called time or t; else the sampling rate tells it, which
    `wanted` or a number called fs, dt and the like gives. Structures and rows of cells that have times of their own are
    records of their own. `wanted` may also give the number of a column, or of a cell in its row.
    """
    numbers = {name: array for name, array in arrays.items() if array.dtype.kind in "fiub" and array.size}
    for name in wanted.variables:
        if name not in numbers:
            raise NotARecord(f"no array of numbers called {name}; there: {', '.join(numbers) or 'none'}")
    column = _time_column(numbers, wanted)
    if column is not None:
        return _split(numbers, column, wanted)
    clocks = _clocks(numbers, wanted, source)
    if len(clocks) < 2:
        return _one_record(numbers, next(iter(clocks.values()), ""), wanted, "")
    found = []
    for scope, clock in clocks.items():
        mine = {name: array for name, array in numbers.items() if _nearest(name, clocks) == scope}
        here = Wanted(wanted.sample_rate, None, [name for name in wanted.variables if name in mine], wanted.time_scale)
        if here.variables or not wanted.variables:
            found += _one_record(mine, clock, here, scope)
    outside = [name for name in wanted.variables if _nearest(name, clocks) is None]
    if outside:
        several = ", ".join(clocks.values())
        raise NotARecord(f"several arrays are times ({several}), and none of them is that of {outside[0]}")
    return found


def _one_record(numbers: Mapping[str, np.ndarray], clock: str, wanted: Wanted, record: str) -> list[Channel]:
    """The histories that share one time, whose array `clock` names; empty where the sampling rate tells it."""
    times = None
    if clock:
        times = own_times(numbers[clock].astype(float).ravel() * wanted.time_scale, wanted, clock)
    names = wanted.variables or [name for name in numbers if name != clock]
    long = {name: _columns(numbers[name], None if times is None else times.size) for name in names}
    long = {name: columns for name, columns in long.items() if columns is not None}
    if not wanted.variables and times is None and long:
        most = max(columns.shape[0] for columns in long.values())
        long = {name: columns for name, columns in long.items() if columns.shape[0] == most}
    left_out = [name for name in wanted.variables if name not in long]
    if left_out or not long:
        _refuse_deep(numbers, left_out or names)
    if left_out:
        raise NotARecord(f"{left_out[0]} is not as long as the time, {clock}")
    if not long:
        raise NotARecord("no array of at least two samples" + (f" as long as {clock}" if clock else ""))
    interval = 0.0 if times is not None else 1.0 / _rate(numbers, wanted)
    found = []
    for name, columns in long.items():
        when = even_times(columns.shape[0], interval) if times is None else times
        for number, values in enumerate(columns.T, 1):
            found.append(Channel(name if columns.shape[1] == 1 else f"{name}_{number}", values, when, record=record))
    return found


def _refuse_deep(numbers: Mapping[str, np.ndarray], names: Iterable[str]) -> None:
    """Raise `NotARecord` where one of some arrays has more dimensions than samples and sensors."""
    for name in names:
        if np.squeeze(numbers[name]).ndim > 2:
            raise NotARecord(
                f"{name} has {numbers[name].ndim} dimensions, {numbers[name].shape}; accepted: two, samples and sensors"
            )


def _time_column(numbers: Mapping[str, np.ndarray], wanted: Wanted) -> int | None:
    """The number of the column of times that the caller gives, from 1; none where he means an array."""
    if wanted.time is None or not wanted.time.isdecimal():
        return None
    return None if _called(numbers, wanted.time) else int(wanted.time)


def _split(numbers: Mapping[str, np.ndarray], column: int, wanted: Wanted) -> list[Channel]:
    """Of each array with columns its times and its histories: a record of its own each."""
    tables = {name: _columns(numbers[name], None) for name in wanted.variables or numbers}
    found = []
    for name, table in tables.items():
        if table is None or table.shape[1] < 2:
            if wanted.variables:
                raise NotARecord(f"{name} has no column of times; accepted: --time NAME, or --sample-rate")
            continue
        if not 1 <= column <= table.shape[1]:
            raise NotARecord(f"{name} has {table.shape[1]} columns, and --time is {column}")
        times = table[:, column - 1].astype(float) * wanted.time_scale
        others = [number for number in range(1, table.shape[1] + 1) if number != column]
        for number in others:
            label = name if len(others) == 1 else f"{name}_{number}"
            found.append(Channel(label, table[:, number - 1], times, record=name))
    if not found:
        _refuse_deep(numbers, list(tables))
        raise NotARecord(f"--time is {column}, and no array has columns; accepted: --time NAME, or --sample-rate")
    return found


def _clocks(numbers: Mapping[str, np.ndarray], wanted: Wanted, source: str) -> dict[str, str]:
    """The arrays of times by the structures or rows of cells that they are in; `` is the file itself."""
    if wanted.time in numbers:
        return {"": wanted.time}
    if wanted.time is not None:
        found = _called(numbers, wanted.time)
        if not found:
            raise NotARecord(
                f"no array of numbers called {wanted.time} in {source}; there: {', '.join(numbers) or 'none'}"
            )
    else:
        found = [name for name in _named(numbers, TIME_NAMES) if _is_row(numbers[name])]
    clocks: dict[str, str] = {}
    for name in found:
        clocks.setdefault(_scope(name), name)
    return clocks


def _called(numbers: Mapping[str, np.ndarray], name: str) -> list[str]:
    """Arrays of one row or column that have this name in their structure, or in the row of their cells."""
    return [path for path, array in numbers.items() if _last(path) == name and _is_row(array)]


def _is_row(array: np.ndarray) -> bool:
    """Whether it is a single row or column of more than one number."""
    return array.size > 1 and max(array.shape) == array.size


def _scope(name: str) -> str:
    """The structure, or the row of cells, that an array is in: `Fe.Out` of `Fe.Out.Time`."""
    return name.rpartition(".")[0]


def _last(name: str) -> str:
    """An array's name within that: `Time` of `Fe.Out.Time`."""
    return name.rpartition(".")[2]


def _nearest(name: str, clocks: Mapping[str, str]) -> str | None:
    """The innermost structure around an array that has times."""
    scope = _scope(name)
    while scope not in clocks and scope:
        scope = _scope(scope)
    return scope if scope in clocks else None


def _single(values: np.ndarray) -> float:
    """The only number of an array; infinite where it has not one, or one that is not above 0."""
    value = float(values.ravel()[0]) if values.size == 1 else np.inf
    return value if value > 0.0 else np.inf


def _rate(numbers: Mapping[str, np.ndarray], wanted: Wanted) -> float:
    """The sampling rate [Hz]: a single number of the file, or as the caller says.

    Raises `NotARecord` where neither tells it, or the two differ.
    """
    told = {name: _single(numbers[name]) for name in _named(numbers, RATE_NAMES)}
    told |= {name: 1.0 / _single(numbers[name]) for name in _named(numbers, INTERVAL_NAMES)}
    name, rate = next(((name, rate) for name, rate in told.items() if 0.0 < rate < np.inf), ("", wanted.sample_rate))
    if name and wanted.sample_rate is not None and not np.isclose(rate, wanted.sample_rate, rtol=1e-6):
        raise NotARecord(f"has a sampling rate of its own, {name}, of {rate:g} Hz; accepted: without --sample-rate")
    if rate is not None:
        return rate
    raise NotARecord(
        "nothing tells the times; give --sample-rate, or --time with the name of their array, or with the number of "
        f"their column; there: {', '.join(f'{name} {array.shape}' for name, array in numbers.items())}"
    )


def _named(numbers: Mapping[str, np.ndarray], names: Iterable[str]) -> Iterable[str]:
    """Arrays of some names, in whatever letters, also inside a structure: `run1.time`."""
    return (name for wanted in names for name in numbers if _last(name.lower()) == wanted)


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
