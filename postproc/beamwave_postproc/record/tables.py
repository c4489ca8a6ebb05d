"""Tables of text as loggers write them: long headers, clocks and dates, decimal commas, several tables in one file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ..terminal import printable
from .channels import Channel, NotARecord, Wanted, even_times, own_times

SEPARATORS = ("\t", ";", ",", None)  # None: any number of blanks
PROBED = 2000  # lines that tell the form
NEAR = 4  # lines above the rows, among which names and units stand
LEAST_ROWS = 8  # of a table; fewer lines of numbers are part of a header
NAMES_OF_TIME = ("time", "t", "x_value", "zeit", "temps", "tiempo", "tempo", "elapsed time", "timestamp", "datetime")
SECONDS = {
    "s": 1.0,
    "sec": 1.0,
    "seconds": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "µs": 1e-6,
    "μs": 1e-6,
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}
UNIT = re.compile(r"^(?P<name>.*?)\s*(?:\((?P<round>[^()]*)\)|\[(?P<square>[^\[\]]*)\]|/(?P<slash>[^/\s]+))$")
CLOCK = re.compile(r"\d[\d.,:/ TZ+-]*([:/-]|\.\d+\.)\d[\d.,:/ TZ+-]*")  # 12:00:00.25, 1.2.2024, 2024-02-01T12:00Z
DATE = re.compile(r"(\d{1,2})([-/.])(\d{1,2})\2(\d{4}|\d{2})(?!\d)")  # whose year is last
FORTRAN = re.compile(r"[-+.\d]+[dD][-+]?\d+")  # 1.5D+03
MISSING = ("na", "n/a", "#n/a", "null", "none", "--", "missing", "1.#qnan", "-1.#ind")  # words for no sample
END_OF_HEADER = "***End_of_Header***"


@dataclass
class Table:
    """One block of rows, cell by cell, and what stands above it."""

    rows: list[list[str]]  # (rows, columns)
    names: list[str]  # (columns), empty where nothing stands above a column
    units: list[str]  # (columns)
    comma: bool  # the decimal mark
    line: int  # of the first row


def text_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """The histories of each table in a text, as a record of its own where there are several.

    The times are the column that `wanted` names, by name or number; else the one called time or the like, or the first
    where it holds dates and clocks; else the sampling rate tells them. Raises `NotARecord` where there is no table.
    """
    lines = _decoded(path.read_bytes()).splitlines()
    if lines and lines[0].startswith("LabVIEW Measurement"):
        return _labview(lines, wanted)
    tables = tables_of(lines)
    if not tables:
        raise NotARecord(f"no table of numbers: {LEAST_ROWS} rows or more of one length")
    found = []
    for number, table in enumerate(tables, 1):
        found += _channels(table, wanted, "" if len(tables) == 1 else str(number))
    return found


def _decoded(content: bytes) -> str:
    """A text by its byte-order mark, else as UTF-8, else as Latin-1, in which every byte is a letter."""
    for mark, name in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig")):
        if content.startswith(mark):
            return content.decode(name)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


# Tables


def tables_of(lines: Sequence[str]) -> list[Table]:
    """The tables of a text, parted by what makes the most cells in rows of its first lines."""

    def cells(separator: str | None) -> int:
        return sum(len(table.rows) * len(table.names) for table in _tables(lines[:PROBED], separator))

    return _tables(lines, max(SEPARATORS, key=cells), chosen=True)


def _tables(lines: Sequence[str], separator: str | None, *, chosen: bool = False) -> list[Table]:
    """Runs of lines with as many cells, of which the first and at least one more line are numbers or clocks.

    Raises `NotARecord` by the chosen separator where a word stands among the numbers, as a logger writes OVR.
    """
    comma = separator != "," and _has_decimal_commas(lines, separator)
    cells = [_cells(line, separator) for line in lines]
    is_row = [any(row) and all(_tells(cell, comma) for cell in row) for row in cells]
    found = []
    first = end = 0  # of the table before
    while first < len(cells):
        last = first
        while last < len(cells) and is_row[last] and len(cells[last]) == len(cells[first]):
            last += 1
        if chosen and last > first:
            _refuse_words(cells, is_row, first, last, comma)
        if last - first >= LEAST_ROWS:
            above = lines[max(end, first - NEAR) : first]
            found.append(_table(cells[first:last], above, separator, comma, first + 1))
            end = last
        first = max(last, first + 1)
    return found


def _refuse_words(cells: list[list[str]], is_row: list[bool], first: int, last: int, comma: bool) -> None:
    """Raise `NotARecord` where lines of as many cells that begin as a row stand between the names and a table, or within it."""
    width = len(cells[first])
    behind = first
    while behind > 0 and len(cells[behind - 1]) == width and _begins_row(cells[behind - 1], comma):
        behind -= 1
    if 0 < behind < first and len(cells[behind - 1]) == width:
        _refuse_word(cells, behind, comma)
    behind = last
    while behind < len(cells) and not is_row[behind] and len(cells[behind]) == width:
        if not _begins_row(cells[behind], comma):
            return
        behind += 1
    if last < behind < len(cells) and len(cells[behind]) == width:
        _refuse_word(cells, last, comma)


def _begins_row(row: list[str], comma: bool) -> bool:
    """Whether a line begins with a number or clock."""
    return bool(row[0]) and _tells(row[0], comma)


def _refuse_word(cells: list[list[str]], line: int, comma: bool) -> None:
    """Raise `NotARecord` for the first word of a line."""
    word = next(cell for cell in cells[line] if not _tells(cell, comma))
    raise NotARecord(f"line {line + 1}: {printable(word)!r} stands among numbers; accepted: a number, or nothing")


def _cells(line: str, separator: str | None) -> list[str]:
    """The cells of a line, without quotes and blanks."""
    if line.lstrip().startswith(("#", "%")):
        line = line.lstrip(" #%")
    return [cell.strip().strip("\"'").strip() for cell in line.split(separator)]


def _has_decimal_commas(lines: Sequence[str], separator: str | None) -> bool:
    """Whether more cells are numbers with a comma than with a point."""
    cells = [cell for line in lines[:PROBED] for cell in _cells(line, separator)]
    return sum(map(_with_comma, cells)) > sum("." in cell and _number(cell, False) is not None for cell in cells)


def _with_comma(cell: str) -> bool:
    """Whether a cell is a number with a decimal comma."""
    return cell.count(",") == 1 and _number(cell, True) is not None


def _number(cell: str, comma: bool) -> float | None:
    """The number in a cell, NaN where it is missing; none where it is a word."""
    text = cell.replace(",", ".") if comma else cell
    if text.lower() in MISSING:
        return np.nan
    if FORTRAN.fullmatch(text):
        text = text.lower().replace("d", "e")
    try:
        return float(text)
    except ValueError:
        return None


def _tells(cell: str, comma: bool) -> bool:
    """Whether a cell may stand in a row: a number, a clock or date, or nothing."""
    return not cell or _number(cell, comma) is not None or _is_clock(cell)


def _is_clock(cell: str) -> bool:
    """Whether a cell is a date, a time of day or both, as in 2024-05-01T12:00:00.25 or 12:00:00,25."""
    return bool(CLOCK.fullmatch(cell))


def _table(rows: list[list[str]], header: Sequence[str], separator: str | None, comma: bool, line: int) -> Table:
    """Rows with the names and units that stand above them, which may be parted otherwise than the rows."""
    count = max(column + 1 for row in rows for column, cell in enumerate(row) if cell)  # rows may end in separators
    above: list[list[str]] = []
    for mark in (separator, *SEPARATORS):
        split = [_cells(line, mark) for line in header]
        if mark is None:  # units in brackets are part of the name before
            joined = [_cells(re.sub(r"\s+(?=[\[(])", "", line), mark) for line in header]
            split = [short if len(row) > len(rows[0]) else row for row, short in zip(split, joined)]
        split = [row for row in split if len(row) <= len(rows[0])]
        split = [([cell.rstrip(",;") for cell in row] + [""] * count)[:count] for row in split]
        above = above or [row for row in split if sum(map(bool, row)) > count // 2][-2:]
    names, units = [""] * count, [""] * count
    if len(above) == 2 and all(_is_unit(cell) for cell in above[1]):
        names, units = above[0], [cell.strip("()[]") for cell in above[1]]
    elif above:
        names = above[-1]
    for column, name in enumerate(names):
        said = UNIT.match(name)
        if said and not units[column]:
            names[column] = said["name"]
            units[column] = next(part for part in (said["round"], said["square"], said["slash"]) if part is not None)
    return Table([row[:count] for row in rows], names, units, comma, line)


def _is_unit(cell: str) -> bool:
    """Whether a cell in a second line of header is a unit, as in (V), m/s^2 or nothing."""
    return (
        not cell
        or cell[0] in "(["
        or cell in SECONDS
        or bool(re.fullmatch(r"[A-Za-zµμ°%]{1,4}([/^*·][\w²^-]+)*", cell))
    )


# Channels


def _channels(table: Table, wanted: Wanted, record: str) -> list[Channel]:
    """The histories of a table: all columns of numbers but that of the times."""
    numbers = [_column(table, column) for column in range(len(table.names))]
    clock = _clock_of(table, wanted)
    if clock is None:
        if wanted.sample_rate is None:
            raise NotARecord(
                f"no column of times among {_listed(table)}; accepted: --time NAME or number, or --sample-rate"
            )
        times = even_times(len(table.rows), 1.0 / wanted.sample_rate)
    else:
        own = _times(table, clock, numbers[clock], wanted)
        times = own_times(own, wanted, f"column {table.names[clock] or clock + 1}")
    found = []
    for column, values in enumerate(numbers):
        name = table.names[column] or f"column_{column + 1}"
        asked = not wanted.variables or name in wanted.variables or str(column + 1) in wanted.variables
        if column == clock or not asked or values is None or not np.isfinite(values).any():
            continue
        found.append(Channel(name, values, times, unit=table.units[column], record=record, line=table.line))
    if not found:
        raise NotARecord(f"no column of numbers besides the times among {_listed(table)}")
    return found


def _listed(table: Table) -> str:
    """The columns, for a message."""
    return ", ".join(name or f"column {number}" for number, name in enumerate(table.names, 1))


def _column(table: Table, column: int) -> np.ndarray | None:
    """The numbers of a column, NaN where a cell is empty; none where it holds clocks."""
    values = [_number(row[column], table.comma) if row[column] else np.nan for row in table.rows]
    return None if None in values else np.array(values, dtype=float)


def _clock_of(table: Table, wanted: Wanted) -> int | None:
    """The column of the times; none where nothing tells that one is."""
    if wanted.time is not None:
        if wanted.time in table.names:
            return table.names.index(wanted.time)
        if wanted.time.isdecimal() and 1 <= int(wanted.time) <= len(table.names):
            return int(wanted.time) - 1
        raise NotARecord(f"no column called {wanted.time} among {_listed(table)}")
    for column, name in enumerate(table.names):
        if name.lower() in NAMES_OF_TIME:
            return column
    if _is_clock(table.rows[0][0]) or table.units[0] in SECONDS:
        return 0
    return None


def _times(table: Table, clock: int, numbers: np.ndarray | None, wanted: Wanted) -> np.ndarray:
    """Times in s: of dates and clocks since the first one, across midnight too."""
    if numbers is not None:
        scale = wanted.time_scale if wanted.time_scale != 1.0 else SECONDS.get(table.units[clock].lower(), 1.0)
        return numbers * scale
    cells = [row[clock].replace(",", ".") for row in table.rows]
    dates = [DATE.match(cell) for cell in cells]
    year_is_last = all(dates)
    if year_is_last:
        cells = _year_first(cells, dates, f"column {clock + 1}", wanted.date_order)
    try:
        form = None if not year_is_last and ("-" in cells[0] or "/" in cells[0]) else "mixed"
        stamps = pd.to_datetime(pd.Series(cells), format=form)
    except (ValueError, OverflowError) as failure:
        raise NotARecord(f"column {clock + 1} holds dates or clocks that cannot be told: {cells[0]!r}") from failure
    seconds = (stamps - stamps.iloc[0]).dt.total_seconds().to_numpy(dtype=float, copy=True)
    if ":" in cells[0] and not re.search(r"\d[-/]\d", cells[0]):
        seconds += 86400.0 * np.cumsum(np.diff(seconds, prepend=seconds[0]) < -43200.0)
    return np.round(seconds, 9)  # clocks have no more digits; sums across midnight do


def _year_first(cells: list[str], dates: list[re.Match[str]], column: str, order: str | None) -> list[str]:
    """Dates as ISO writes them, from those whose year is last.

    Points stand behind days, as in 1.2.2024; else a number above 12 in any cell tells where the days are. Where there
    is none, the caller says it; raises `NotARecord` if the dates change and nothing tells.
    """
    first, second = ({int(date[group]) for date in dates} for group in (1, 3))
    if order is None and dates[0][2] == ".":
        order = "day"
    if order is None and max(first | second) > 12:
        order = "day" if max(first) > 12 else "month"
    if order is None and len(first) * len(second) > 1:
        raise NotARecord(
            f"{column} holds dates such as {dates[-1][0]}, whose day or month may be first; "
            "accepted: --date-order day or month"
        )
    day, month = (1, 3) if order == "day" else (3, 1)
    return [
        f"{'20' if len(date[4]) == 2 else ''}{date[4]}-{date[month]:0>2}-{date[day]:0>2}{cell[date.end() :]}"
        for cell, date in zip(cells, dates, strict=True)
    ]


# LabVIEW


def _labview(lines: Sequence[str], wanted: Wanted) -> list[Channel]:
    """A LabVIEW measurement file: each part below a header of its own is a record, unless it continues the one before."""
    separator = {"Tab": "\t", "Comma": ","}.get(_said(lines, "Separator", None), "\t")
    split = [line.split(separator) for line in lines]
    comma = _said(lines, "Decimal_Separator", separator) == ","
    x_columns = (_said(lines, "X_Columns", separator) or "One").lower()
    ends = [number for number, row in enumerate(split) if row[0].strip() == END_OF_HEADER][1:]
    records: list[list[Channel]] = []
    for end in ends:
        begin = next(
            (n for n in range(end - 1, -1, -1) if split[n][0].strip() == END_OF_HEADER or not lines[n].strip()), 0
        )
        stride = 2 if x_columns == "multi" else 1
        head = {row[0].strip(): row[1::stride] for row in split[begin + 1 : end]}
        count = int(head["Channels"][0])
        part = _part(split[end + 1 :], head, count, (comma, x_columns), wanted)
        if records and _goes_on(records[-1], part):
            for channel, after in zip(records[-1], part):
                channel.values = np.append(channel.values, after.values)
                channel.times = np.append(channel.times, after.times)
        elif part:
            records.append(part)
    if not records:
        raise NotARecord("a LabVIEW measurement without samples")
    for number, channels in enumerate(records, 1):
        for channel in channels:
            channel.record = "" if len(records) == 1 else str(number)
    return [channel for channels in records for channel in channels]


def _goes_on(before: list[Channel], after: list[Channel]) -> bool:
    """Whether channels are those of the part before, an interval later, as of a recorder that writes in portions."""

    def follows(first: Channel, then: Channel) -> bool:
        steps = np.diff(np.append(first.times[-2:], then.times[:1]))
        even = steps.size == 2 and abs(steps[1] - steps[0]) < 0.5 * steps[0]
        return even and (first.name, first.unit) == (then.name, then.unit)

    return len(before) == len(after) and all(map(follows, before, after))


def _said(lines: Sequence[str], key: str, separator: str | None) -> str | None:
    """What the head of the file says of a key."""
    for line in lines[:100]:
        row = re.split(r"[\t,]", line, maxsplit=1) if separator is None else line.split(separator, 1)
        if row[0].strip() == key:
            return "," if row[1][:1] == "," else row[1].split(separator)[0].strip()
    return None


def _part(
    rows: list[list[str]],
    head: dict[str, list[str]],
    count: int,
    form: tuple[bool, str],
    wanted: Wanted,
) -> list[Channel]:
    """The channels of one part: times of a column, of a column for each, or of `X0` and `Delta_X`.

    LabVIEW prints times with six decimals and intervals with seven digits: a column that is no further from `X0` and `Delta_X` is
    evenly spaced.
    `Samples` is that of the first portion that was written, and tells nothing; further ones may follow without a header.
    """
    comma, x_columns = form
    other = next((cell.strip() for cell in head.get("X_Dimension", []) if cell.strip() not in ("", "Time")), "")
    if other:
        raise NotARecord(f"its samples are over {other.lower()}; accepted: histories in time")
    names = [cell.strip() for cell in rows[0]]
    width = 2 * count if x_columns == "multi" else count + 1
    block = []
    for row in rows[1:]:
        if row[0].strip() and _number(row[0].strip(), comma) is None:
            break  # the next header
        values = [_number(cell.strip(), comma) for cell in (row + [""] * width)[:width]]
        if any(value is not None for value in values):
            block.append([np.nan if value is None else value for value in values])
    table = np.array(block, dtype=float).reshape(-1, width)
    found = []
    for channel in range(count):
        column = 2 * channel + 1 if x_columns == "multi" else channel + 1
        values = table[:, column]
        values = values[: np.flatnonzero(np.isfinite(values))[-1] + 1] if np.isfinite(values).any() else values[:0]
        if values.size == 0:
            continue
        times = table[: values.size, column - 1 if x_columns == "multi" else 0]
        if x_columns == "no" or not np.isfinite(times).all() or "Delta_X" in head:
            interval = _cell(head, "Delta_X", channel, comma)
            even = even_times(values.size, interval, _cell(head, "X0", channel, comma))
            if not (np.abs(times - even) > 0.51e-6 + 5e-7 * np.abs(even)).any():
                times = even
        name = names[column] if column < len(names) and names[column] else f"channel_{channel + 1}"
        if not wanted.variables or name in wanted.variables:
            unit = (head.get("Y_Unit_Label", []) + [""] * count)[channel].strip()
            found.append(Channel(name, values, own_times(wanted.time_scale * times, wanted, "X_Value"), unit=unit))
    return found


def _cell(head: dict[str, list[str]], key: str, channel: int, comma: bool) -> float:
    """A number of a channel in the head of a part; raises `NotARecord` where it is missing."""
    cells = head.get(key, [])
    value = _number(cells[min(channel, len(cells) - 1)].strip(), comma) if cells else None
    if value is None:
        raise NotARecord(f"the head of a part has no {key}")
    return value
