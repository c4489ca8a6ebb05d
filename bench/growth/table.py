"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table

from .scenes import AXES
from .slope import LARGEST, bound, slope

FIRST = "<!-- growth: bench/growth.sh writes from here -->"

WORDS = """\
## How time and memory grow

Made by `bench/growth.sh` ([bench/](../bench/README.md#growth) describes it). Each size is a run of `beamwave run` as a process of
its own. The tables give its CPU seconds, medians of up to {rounds} interleaved runs, and its peak memory. The first table gives
the power of the size to which a cost grows, from the largest {largest} sizes without start-up. The bound of the memory is
twice the result plus 200 MB.

![Time and memory against modes, samples and points]({picture})
"""


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and tables."""
    rounds = max(row["runs"] for row in measured["rows"])
    words = WORDS.format(rounds=rounds, largest=LARGEST, picture=picture)
    about, rows = measured_with(measured["machine"]), measured["rows"]
    return "\n\n".join([words.strip(), about, slopes(rows), "All sizes:", details(rows)])


def slopes(rows: list[dict[str, Any]]) -> str:
    """One row for each axis."""
    body = [["varied", "fixed", "up to", "power of time", "power of memory", "largest memory over its bound"]]
    for axis in AXES:
        own = [row for row in rows if row["axis"] == axis.name]
        powers = [f"{slope(own, name):.2f}" for name in ("cpu_seconds", "memory_bytes")]
        part = max(row["memory_bytes"] / bound(row) for row in own)
        body.append([axis.name, axis.besides, f"{own[-1]['size']}", *powers, f"{part:.2f}"])
    return table(body)


def details(rows: list[dict[str, Any]]) -> str:
    """Every size."""
    body = [["grows", "size", "CPU s", "memory MB", "result MB", "bound MB", "runs"]]
    for row in rows:
        sizes = [f"{value / 1e6:.0f}" for value in (row["memory_bytes"], row["result_bytes"], bound(row))]
        body.append([row["axis"], str(row["size"]), f"{row['cpu_seconds']:.2g}", *sizes, str(row["runs"])])
    return table(body)
