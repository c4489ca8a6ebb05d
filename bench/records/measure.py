"""Every tool on the draws of every cell."""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np

from . import beamwave, esprit, harminv, hlsvd, pyoma
from .cells import CELLS, NOISE, SMALL_CELLS, Cell, Draw, draw, lines_of
from .tool import Lines, Tool

TOOLS = (beamwave.TOOL, esprit.TOOL, hlsvd.TOOL, harminv.TOOL, pyoma.TOOL)
SMALL_DRAWS = 4
PART = "BEAMWAVE_BENCH_PART"  # in the environment: which part of the draws is tried
FAR = 5.0  # bounds, or one bin if that is more, from a line to what is taken for it


def measure(small: bool) -> list[dict[str, Any]]:
    """One row for each cell and tool; a tool that is missing has one row that says so."""
    rows: list[dict[str, Any]] = [{"peer": tool.name, "not_measured": f"no {tool.missing()}"} for tool in TOOLS if tool.missing()]
    able = [tool for tool in TOOLS if not tool.missing()]
    for cell in SMALL_CELLS if small else CELLS + NOISE:
        draws = sensible_draws(cell, SMALL_DRAWS if small else round(cell.draws * float(os.environ.get(PART, "1"))))
        for tool in able:
            rows.append(row(tool, cell, draws))
    compare(rows)
    return [{name: value for name, value in row.items() if name != "squares"} for row in rows]


def sensible_draws(cell: Cell, count: int) -> list[Draw]:
    """Draws in which the two lines of a pair can be told apart."""
    return [drawn for number in range(count) if (drawn := draw(cell, number)).sensible]


def row(tool: Tool, cell: Cell, draws: list[Draw]) -> dict[str, Any]:
    """Numbers of one tool in one cell."""
    known = {"peer": tool.name, "cell": cell.words}
    if why := tool.refuses(cell):
        return {**known, "refused": why}
    if cell in NOISE:
        return noise_row(tool, cell, draws)
    tried = draws[: cell.few] if tool.slow else draws
    answers, seconds = tool.estimate(cell, tried)
    matched = [match(drawn, lines, cell) for drawn, lines in zip(tried, answers)]
    squares = np.concatenate([pairs for pairs, _, _ in matched])  # of frequency and decay, over the bound: (draws, lines, 2)
    inside = np.concatenate([held for _, held, _ in matched])
    found = np.isfinite(squares[:, 0])
    print(f"  {cell.words}, {tool.name}: {1e3 * seconds / len(tried):.3g} ms", file=sys.stderr, flush=True)
    return {
        **known,
        "draws": len(tried),
        "milliseconds": rounded(1e3 * seconds / len(tried)),
        "over_bound": [rounded(value) for value in squares[found].mean(axis=0)] if found.any() else None,
        "missed": rounded(1 - found.mean()),
        "extra": rounded(np.mean([extra for _, _, extra in matched])),
        "inside": None if np.isnan(inside[found]).any() or not found.any() else [rounded(v) for v in inside[found].mean(axis=0)],
        "squares": squares,
    }


def noise_row(tool: Tool, cell: Cell, draws: list[Draw]) -> dict[str, Any]:
    """Lines of a tool in noise alone; one that is told how many lines there are finds as many."""
    known = {"peer": tool.name, "cell": cell.words}
    if tool.told != "nothing":
        return {**known, "refused": "is told of lines"}
    answers, seconds = tool.estimate(cell, draws)
    print(f"  {cell.words}, {tool.name}: {1e3 * seconds / len(draws):.3g} ms", file=sys.stderr, flush=True)
    return {
        **known,
        "false": rounded(np.mean([len(lines.frequencies) > 0 for lines in answers])),
        "tried": len(draws),
    }


def match(drawn: Draw, lines: Lines, cell: Cell) -> tuple[np.ndarray, np.ndarray, int]:
    """Squares of errors over their bounds; whether the intervals hold the truth, (lines, 2); how many lines are too many.

    Each true line has the nearest one found, and none has two. One that is too far away is missed: nan.
    """
    count = lines_of(cell)
    squares, held = np.full((count, 2), np.nan), np.full((count, 2), np.nan)
    distance = np.abs(drawn.frequencies[:, None] - lines.frequencies[None, :])
    far = np.maximum(1.0 / cell.samples, FAR * drawn.bounds[0])
    distance[distance > far[:, None]] = np.inf
    while np.isfinite(distance).any():
        line, nearest = np.unravel_index(np.argmin(distance), distance.shape)
        errors = np.array([lines.frequencies[nearest] - drawn.frequencies[line], lines.decays[nearest] - drawn.decays[line]])
        squares[line] = (errors / drawn.bounds[:, line]) ** 2
        if lines.frequency_errors is not None and lines.decay_errors is not None:
            held[line] = np.abs(errors) <= [lines.frequency_errors[nearest], lines.decay_errors[nearest]]
        distance[line], distance[:, nearest] = np.inf, np.inf
    matched = int(np.isfinite(squares[:, 0]).sum())
    return squares, held, len(lines.frequencies) - matched


def compare(rows: list[dict[str, Any]]) -> None:
    """Say by how many standard deviations a tool is better than the program on the same lines: error of frequency, error of decay
    where both have found the line, and lines that are missed."""
    ours = {row["cell"]: row["squares"] for row in rows if row["peer"] == beamwave.TOOL.name and "squares" in row}
    for row in rows:
        if "squares" not in row or row["cell"] not in ours or row["peer"] == beamwave.TOOL.name:
            continue
        theirs, own = row["squares"], ours[row["cell"]][: len(row["squares"])]
        both = np.isfinite(own[:, 0]) & np.isfinite(theirs[:, 0])
        missed = np.isnan(own[:, 0]).astype(float) - np.isnan(theirs[:, 0])
        row["better_by"] = [*(deviations(part) for part in (own - theirs)[both].T), deviations(missed)]


def deviations(differences: np.ndarray) -> float:
    """The mean over its own standard deviation, at most 99 of them."""
    if not differences.any():
        return 0.0
    spread = differences.std() / np.sqrt(len(differences))
    return round(float(np.clip(differences.mean() / max(spread, 1e-300), -99, 99)), 1)


def rounded(value: float) -> float:
    """Three digits."""
    return float(f"{value:.3g}")
