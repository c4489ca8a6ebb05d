"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table
from growth.slope import slope

from .records import AXES, LINES

FIRST = "<!-- large records: bench/large_records.sh writes from here -->"

WORDS = """\
## Large records

Made by `bench/large_records.sh` ([bench/](../bench/README.md#large-records) describes it). Each size is a run of `beamwave run` as a
process of its own, on a record with {lines} lines in white noise. The tables give its CPU seconds, including reading, its peak memory,
and the size of the samples in double precision. If wall seconds are much larger, other work shared the cores, and
the CPU seconds are larger than on an idle machine, too.

![Time and memory against samples and sensors]({picture})
"""


def record_bytes(row: dict[str, Any]) -> int:
    """The record in double precision."""
    axis = next(axis for axis in AXES if axis.name == row["axis"])
    samples, sensors = axis.shape(row["size"])
    return 8 * samples * sensors


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and tables."""
    rows = measured["rows"]
    words = WORDS.format(lines=LINES, picture=picture)
    return "\n\n".join([words.strip(), measured_with(measured["machine"]), powers(rows), "All sizes:", details(rows)])


def powers(rows: list[dict[str, Any]]) -> str:
    """How time and memory grow along each axis."""
    body = [["varied", "fixed", "up to", "power of time", "power of memory"]]
    for axis in AXES:
        own = [row for row in rows if row["axis"] == axis.name]
        slopes = [f"{slope(own, name):.2f}" for name in ("cpu_seconds", "memory_bytes")]
        body.append([axis.name, axis.besides, f"{own[-1]['size']}", *slopes])
    return table(body)


def details(rows: list[dict[str, Any]]) -> str:
    """Every size."""
    body = [["grows", "size", "CPU s", "wall s", "memory MB", "record MB", "runs"]]
    for row in rows:
        sizes = [f"{value / 1e6:.0f}" for value in (row["memory_bytes"], record_bytes(row))]
        body.append([row["axis"], str(row["size"]), f"{row['cpu_seconds']:.2g}", f"{row['wall_seconds']:.3g}", *sizes, str(row["runs"])])
    return table(body)
