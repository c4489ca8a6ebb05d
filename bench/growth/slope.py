"""How a cost grows: the power of the size, by least squares over the largest sizes, less what is always there."""

from __future__ import annotations

from typing import Any

import numpy as np

LARGEST = 3  # sizes that the slope is taken over
BOUND_FACTOR, BOUND_BYTES = 2, 200e6  # memory stays below twice the result and this


def slope(rows: list[dict[str, Any]], name: str) -> float:
    """Of log cost over log size, the cost of the smallest size taken off where it is less than half of it."""
    last = rows[-LARGEST:] if len(rows) > LARGEST else rows
    sizes = np.log([row["size"] for row in last])
    fixed = rows[0][name] if len(rows) > LARGEST else 0
    costs = [row[name] - fixed if row[name] > 2 * fixed else row[name] for row in last]
    return float(np.polyfit(sizes, np.log(costs), 1)[0])


def bound(row: dict[str, Any]) -> float:
    """Bytes that a run may take."""
    return BOUND_FACTOR * row["result_bytes"] + BOUND_BYTES
