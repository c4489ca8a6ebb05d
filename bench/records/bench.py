"""Error, outliers, coverage and time of beamwave and other tools on the same noisy records."""

from __future__ import annotations

import argparse
import os
from typing import Any

import matplotlib as mpl
import numpy as np
from beamwave_postproc.style import COLOURS, RC
from common.bench import Bench, Measured, Rows
from common.document import measured_with, table
from common.measuring import rounded, say
from matplotlib.figure import Figure

from .cells import CELLS, NOISE, SMALL_CELLS, Cell, Draw, draw, lines_of, nearest_pairs
from .tools import TOOLS, Lines, Tool

SMALL_DRAWS = 4
PART = "BEAMWAVE_BENCH_PART"  # in the environment: which part of the draws is tried
FAR = 5.0  # bounds, or one bin if that is more, from a line to what is taken for it
SURE = 3.0  # standard deviations of a difference that is more than noise
MARKS = "osD^v"

WORDS = """\
## Lines in noise

Made by `bench/records.sh` ([bench/](../bench/README.md#records) describes it). All tools analyse the same seeded records of lines in
noise, 512 samples each. The error is the mean square error of the frequencies, and of the decays, over the Cramér–Rao bound of the
record. No unbiased estimate has less than 1; {draws} draws scatter by about {scatter:.0f} %. A line found further away than a bin, or than
five bounds, counts as missed and not in the error. Information given in addition to the record: {told}.

![Errors over the bound, and time](pictures/records.png)
"""


def measured(options: argparse.Namespace) -> Measured:
    """One row for each cell and tool; a tool that is missing has one row that says so."""
    rows: Rows = [{"peer": tool.name, "not_measured": f"no {tool.missing()}"} for tool in TOOLS if tool.missing()]
    able = [tool for tool in TOOLS if not tool.missing()]
    for cell in SMALL_CELLS if options.small else CELLS + NOISE:
        draws = sensible_draws(cell, SMALL_DRAWS if options.small else round(cell.draws * float(os.environ.get(PART, "1"))))
        for tool in able:
            rows.append(row(tool, cell, draws))
    compare(rows)
    return {"rows": [{name: value for name, value in row.items() if name != "squares"} for row in rows]}


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
    say(f"{cell.words}, {tool.name}: {1e3 * seconds / len(tried):.3g} ms")
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
    say(f"{cell.words}, {tool.name}: {1e3 * seconds / len(draws):.3g} ms")
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
    for line, nearest in nearest_pairs(distance):
        errors = np.array([lines.frequencies[nearest] - drawn.frequencies[line], lines.decays[nearest] - drawn.decays[line]])
        squares[line] = (errors / drawn.bounds[:, line]) ** 2
        if lines.frequency_errors is not None and lines.decay_errors is not None:
            held[line] = np.abs(errors) <= [lines.frequency_errors[nearest], lines.decay_errors[nearest]]
    matched = int(np.isfinite(squares[:, 0]).sum())
    return squares, held, len(lines.frequencies) - matched


def compare(rows: Rows) -> None:
    """Say by how many standard deviations a tool is better than the program on the same lines: error of frequency, error of decay
    where both have found the line, and lines that are missed."""
    ours = {row["cell"]: row["squares"] for row in rows if row["peer"] == TOOLS[0].name and "squares" in row}
    for row in rows:
        if "squares" not in row or row["cell"] not in ours or row["peer"] == TOOLS[0].name:
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


def section(measured: Measured) -> list[str]:
    """Text and tables."""
    rows = measured["rows"]
    told = "; ".join(f"{tool.name}, {tool.told}" for tool in TOOLS)
    draws = max(row.get("draws", 1) for row in rows)
    words = WORDS.format(told=told, draws=draws, scatter=100 * (2 / (3 * draws)) ** 0.5)  # of three lines
    about = measured_with(measured["machine"])
    return [words, about, errors(rows), verdict(rows), false_lines(rows), "All numbers:", details(rows)]


def errors(rows: Rows) -> str:
    """Errors of frequency and decay, a line for each kind of record."""
    body = [["record", *(tool.name for tool in TOOLS)]]
    for cell in dict.fromkeys(row["cell"] for row in rows if "over_bound" in row):
        body.append([cell, *(short(find(rows, tool.name, cell)) for tool in TOOLS)])
    return table(body)


def false_lines(rows: Rows) -> str:
    """Records of noise alone in which the program finds any line."""
    body = [[row["cell"], str(row["tried"]), percent(row["false"])] for row in rows if "false" in row]
    return "Noise alone, with `false_alarm` = 0.01:\n\n" + table([["record", "draws", "with false lines"], *body])


def find(rows: Rows, peer: str, cell: str) -> dict[str, Any]:
    """The row of a tool and a cell; of a tool that is not there what says so."""
    own = [row for row in rows if row["peer"] == peer]
    return next((row for row in own if row.get("cell") == cell), own[0])


def short(row: dict[str, Any]) -> str:
    """Both errors, and how many are missed."""
    if "not_measured" in row:
        return "not measured"
    if "refused" in row:
        return row["refused"]
    if not row["over_bound"]:
        return "all missed"
    missed = f", {percent(row['missed'])} missed" if row["missed"] else ""
    return " and ".join(f"{value:.3g}" for value in row["over_bound"]) + missed


def percent(part: float) -> str:
    """Of the whole."""
    return f"{float(f'{100 * part:.2g}'):g} %"


def verdict(rows: Rows) -> str:
    """Where another tool is better than the program, beyond what the number of draws explains."""
    said = []
    for kind, which in (("Smaller errors of frequency", 0), ("Smaller errors of decay", 1), ("Fewer lines missed", 2)):
        better = [f"{row['peer']} ({row['cell']})" for row in rows if row.get("better_by") and row["better_by"][which] > SURE]
        said.append(f"{kind}: {'; '.join(better) or 'none'}.")
    return (
        f"Better than beamwave by more than {SURE:g} standard deviations of the difference on the same draws (errors where both have "
        "found the line):\n\n" + "\n".join(f"- {line}" for line in said)
    )


def details(rows: Rows) -> str:
    """Every row."""
    body = [["record", "tool", "draws", "frequency", "decay", "missed", "false lines a record", "inside 95 % intervals", "ms a record"]]
    for row in rows:
        if "draws" not in row:
            continue
        over = [f"{value:.3g}" for value in row["over_bound"] or ()] or ["–", "–"]
        inside = " and ".join(percent3(value) for value in row["inside"]) if row["inside"] else "–"
        counts = [percent(row["missed"]), f"{row['extra']:.2g}", inside, f"{row['milliseconds']:.3g}"]
        body.append([row["cell"], row["peer"], str(row["draws"]), *over, *counts])
    return table(body)


def percent3(part: float) -> str:
    """Of the whole, with three digits."""
    return f"{100 * part:.3g} %"


def picture(measured: Measured) -> Figure:
    """A line for each kind of record; at the left the error of the frequency, at the right the time."""
    rows = [row for row in measured["rows"] if "draws" in row]  # those with lines
    cells = list(dict.fromkeys(row["cell"] for row in rows))[::-1]
    with mpl.rc_context(RC):
        figure = Figure(figsize=(8.6, 0.9 + 0.32 * len(cells)), layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True)
        for number, peer in enumerate(dict.fromkeys(row["peer"] for row in rows)):
            own = [row for row in rows if row["peer"] == peer]
            style = {"color": COLOURS[number], "marker": MARKS[number], "linestyle": "none", "markersize": 4}
            known = [row for row in own if row["over_bound"]]
            left.plot([row["over_bound"][0] for row in known], [cells.index(row["cell"]) for row in known], label=peer, **style)
            right.plot([row["milliseconds"] for row in own], [cells.index(row["cell"]) for row in own], **style)
        left.axvline(1.0, color="0.6", linewidth=0.8)
        left.set_yticks(range(len(cells)), cells)
        for axes, words in ((left, "Square error of the frequency / bound"), (right, "CPU time of a record (ms)")):
            axes.set_xscale("log")
            axes.set_xlabel(words)
        figure.legend(loc="outside upper center", ncols=5, frameon=False)
    return figure


PACKAGES = ("numpy", "scipy", "hlsvdpropy", "pyOMA-2")
BENCH = Bench("records", "errors of lines in noise beside other tools", measured, section, picture, PACKAGES)
