"""Modes and their sum beside numpy + FINUFFT, in turns in one process, and how far both are from the truth."""

from __future__ import annotations

import argparse
import time
from typing import Any, Callable

import numpy as np
from common.bench import Bench, Measured, Rows
from common.document import measured_with, table
from common.measuring import in_turns, median
from peers.beam import Problem, amplitudes
from peers.reference import wide_roots

from . import rival
from .library import DURATION, GAMMA, Beamwave

SIZES = [(n, 2**power) for power in (12, 16, 20) for n in (200, 1000, 4000, 20000, 200000)]
SMALL = [(200, 2**12)]
TOLERANCES = (3e-11, 1e-12)
REPEATS = 11
CHECKED = 24  # samples, apart from the first and the last
CHUNK = 4096  # modes at a time
NO_UNITS = {"diameter": 4, "density": 1, "youngs_modulus": 1, "angular_velocity": 0, "mass_ratio": GAMMA}  # h = 1

Call = Callable[[], Any]


HEAD = """## Modes and their sum: numpy + FINUFFT

Made by `bench/sum.sh` ([bench/](../bench/README.md#modes-and-their-sum) describes it), in one process on one core. Times are CPU time,
medians of {repeats} interleaved runs. The whole job is roots, shapes at midpoint and tip, and both histories. Errors are those of the
sum at some samples, over the largest displacement, against direct summation in extended precision. *Its way* is the
faster of two ways to use FINUFFT: a transform for each of the two points (`pair`), or one for both points over times of either
sign (`both sides`)."""

COLUMNS = ["modes", "samples", "whole job, ms", "rival, ms", "ratio", "sum alone, ms", "FINUFFT, ms", "ratio", "its way",
           "error", "rival's error"]  # fmt: skip


def seconds(call: Call) -> float:
    """Processor time: on a machine that does other things too, what they take is not counted."""
    start = time.thread_time()
    call()
    return time.thread_time() - start


def truth(n: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Some samples, the same from run to run, and the displacements there, term by term in numpy's longdouble."""
    chosen = np.random.default_rng(1).choice(samples, CHECKED, replace=False)
    chosen = np.unique(np.r_[0, samples - 1, chosen])
    alpha = wide_roots(n, GAMMA)
    weights, _ = amplitudes(Problem(**NO_UNITS), alpha)
    times = np.longdouble(DURATION / samples) * chosen
    total = np.zeros((2, len(chosen)), np.longdouble)
    for first in range(0, n, CHUNK):
        part = slice(first, first + CHUNK)
        total += weights[:, part] @ np.sin(np.outer(alpha[part] ** 2, times))
    return chosen, total


def compare(beamwave: Beamwave, n: int, samples: int, tolerance: float, repeats: int, known: tuple) -> dict[str, Any]:
    """One row of the table."""
    terms, ours = rival.modes(n, GAMMA), beamwave.terms(n)
    chosen, exact = known

    def error(histories: np.ndarray) -> float:
        return float(f"{float(np.abs(histories[:, chosen] - exact).max() / np.abs(histories).max()):.1e}")

    row: dict[str, Any] = {"tolerance": tolerance, "modes": n, "samples": samples}
    row["error"] = error(beamwave.job(n, samples))
    calls = {
        "job": lambda: beamwave.job(n, samples),
        "sum": lambda: beamwave.sum(samples, ours),
    }
    if rival.finufft:
        transform = rival.Transform(samples, DURATION / samples, tolerance)
        transform.choose(seconds, *terms)
        row |= {"way": transform.way, "rival_error": error(rival.job(n, GAMMA, transform))}
        calls |= {"rival": lambda: rival.job(n, GAMMA, transform), "finufft": lambda: transform(*terms)}
    for call in calls.values():
        call()
    answers = in_turns(list(calls), lambda name: (seconds(calls[name]),), repeats)
    return row | {name: median(took for (took,) in runs) for name, runs in zip(calls, answers)}


def measured(options: argparse.Namespace) -> Measured:
    """All rows; every size is checked against the same truth at all tolerances."""
    beamwave = Beamwave(options.beamwave.parents[1])
    repeats = 1 if options.small else options.repeats
    rows: Rows = []
    for n, samples in SMALL if options.small else SIZES:
        known = truth(n, samples)
        rows += [compare(beamwave, n, samples, tolerance, repeats, known) for tolerance in TOLERANCES]
    return {"repeats": repeats, "rows": sorted(rows, key=lambda row: -row["tolerance"])}


def section(measured: Measured) -> list[str]:
    """A table for every accuracy, and where it was measured."""
    parts = [HEAD.format(repeats=measured["repeats"])]
    for tolerance in dict.fromkeys(row["tolerance"] for row in measured["rows"]):
        rows = [row for row in measured["rows"] if row["tolerance"] == tolerance]
        parts += [f"Accuracy of the sum {tolerance:.0e} of the peak:", table([COLUMNS, *map(cells, rows)])]
    return [*parts, measured_with(measured["machine"])]


def cells(row: dict[str, Any]) -> list[str]:
    """A row as it is shown."""

    def both(ours: str, theirs: str) -> list[str]:
        alone = f"{1e3 * row[ours]:.3g}"
        return [alone, f"{1e3 * row[theirs]:.3g}", f"{row[ours] / row[theirs]:.2f}"] if theirs in row else [alone, "–", "–"]

    size = [str(row["modes"]), f"2^{row['samples'].bit_length() - 1}"]
    errors = [f"{row['error']:.0e}", f"{row['rival_error']:.0e}" if "rival_error" in row else "–"]
    return [*size, *both("job", "rival"), *both("sum", "finufft"), row.get("way", "–"), *errors]


BENCH = Bench("sum", "modes and their sum beside numpy + FINUFFT", measured, section, packages=("numpy", "finufft"),
              options={"--repeats": {"type": int, "default": REPEATS, "help": "turns of every size"}})  # fmt: skip
