"""One row: what both sides take for the whole job and for the sum alone, in turns, and how far each is from the truth."""

from __future__ import annotations

import statistics
import time
from typing import Any, Callable

import numpy as np

from . import reference, rival
from .library import DURATION, GAMMA, Beamwave

SIZES = [(n, 2**power) for power in (12, 16, 20) for n in (200, 1000, 4000, 20000, 200000)]
SMALL = [(200, 2**12)]
TOLERANCES = (3e-11, 1e-12)
REPEATS = 11
CHECKED = 24  # samples, apart from the first and the last

Call = Callable[[], Any]


def seconds(call: Call) -> float:
    """Processor time: on a machine that does other things too, what they take is not counted."""
    start = time.thread_time()
    call()
    return time.thread_time() - start


def interleaved(calls: list[Call], repeats: int) -> list[float]:
    """Medians of calls that take turns."""
    for call in calls:
        call()
    times = [[seconds(call) for call in calls] for _ in range(repeats)]
    return [float(f"{statistics.median(column):.3g}") for column in zip(*times)]


def truth(n: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Some samples, the same from run to run, and the displacements there."""
    chosen = np.random.default_rng(1).choice(samples, CHECKED, replace=False)
    chosen = np.unique(np.r_[0, samples - 1, chosen])
    return chosen, reference.histories(n, GAMMA, DURATION / samples, chosen)


def compare(beamwave: Beamwave, n: int, samples: int, tolerance: float, repeats: int, known: tuple) -> dict[str, Any]:
    """One row of the table."""
    terms, ours = rival.modes(n, GAMMA), beamwave.terms(n)
    chosen, exact = known

    def error(histories: np.ndarray) -> float:
        return float(f"{float(np.abs(histories[:, chosen] - exact).max() / np.abs(histories).max()):.1e}")

    row: dict[str, Any] = {"tolerance": tolerance, "modes": n, "samples": samples}
    row["error"] = error(beamwave.job(n, samples, tolerance))
    calls = {
        "job": lambda: beamwave.job(n, samples, tolerance),
        "sum": lambda: beamwave.sum(samples, tolerance, ours),
    }
    if rival.finufft:
        transform = rival.Transform(samples, DURATION / samples, tolerance)
        transform.choose(seconds, *terms)
        row |= {"way": transform.way, "rival_error": error(rival.job(n, GAMMA, transform))}
        calls |= {"rival": lambda: rival.job(n, GAMMA, transform), "finufft": lambda: transform(*terms)}
    return row | dict(zip(calls, interleaved(list(calls.values()), repeats)))


def measure(beamwave: Beamwave, small: bool, repeats: int) -> list[dict[str, Any]]:
    """All rows; every size is checked against the same truth at all tolerances."""
    rows = []
    for n, samples in SMALL if small else SIZES:
        known = truth(n, samples)
        for tolerance in TOLERANCES:
            rows.append(compare(beamwave, n, samples, tolerance, 1 if small else repeats, known))
    return sorted(rows, key=lambda row: -row["tolerance"])
