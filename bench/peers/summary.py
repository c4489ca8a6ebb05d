"""What a curve of errors against seconds says at a given error."""

from __future__ import annotations

from typing import Any

import numpy as np


def seconds_to_reach(rows: list[dict[str, Any]], level: float) -> float | None:
    """Seconds of the cheapest way to an error of at most `level`: a size, or between two sizes by a power law."""
    found = [row["cpu_seconds"] for row in rows if row["error"] <= level]
    for worse, better in zip(rows, rows[1:]):
        if worse["error"] > level >= better["error"]:
            part = np.log(worse["error"] / level) / np.log(worse["error"] / better["error"])
            found.append(worse["cpu_seconds"] * (better["cpu_seconds"] / worse["cpu_seconds"]) ** part)
    return float(min(found)) if found else None


def text_of_seconds(seconds: float | None) -> str:
    """Two digits, or a dash where no size gets there."""
    return "–" if seconds is None else f"{seconds:.2g}"
