"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table

from .measure import TOOLS

FIRST = "<!-- records: bench/records.sh writes from here -->"
SURE = 3.0  # standard deviations of a difference that is more than noise

WORDS = """\
## Lines in noise

Made by `bench/records.sh` ([bench/](../bench/README.md#records) describes it). All tools analyse the same seeded records of lines in
noise, 512 samples each. The error is the mean square error of the frequencies, and of the decays, over the Cramér–Rao bound of the
record. No unbiased estimate has less than 1; {draws} draws scatter by about {scatter:.0f} %. A line found further away than a bin, or than
five bounds, counts as missed and not in the error. Information given in addition to the record: {told}.

![Errors over the bound, and time]({picture})
"""


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and tables."""
    rows = measured["rows"]
    told = "; ".join(f"{tool.name}, {tool.told}" for tool in TOOLS)
    draws = max(row.get("draws", 1) for row in rows)
    words = WORDS.format(told=told, picture=picture, draws=draws, scatter=100 * (2 / (3 * draws)) ** 0.5)  # of three lines
    parts = [measured_with(measured["machine"]), errors(rows), verdict(rows), false_lines(rows), "All numbers:", details(rows)]
    return "\n\n".join([words.strip(), *parts])


def errors(rows: list[dict[str, Any]]) -> str:
    """Errors of frequency and decay, a line for each kind of record."""
    body = [["record", *(tool.name for tool in TOOLS)]]
    for cell in dict.fromkeys(row["cell"] for row in rows if "over_bound" in row):
        body.append([cell, *(short(find(rows, tool.name, cell)) for tool in TOOLS)])
    return table(body)


def false_lines(rows: list[dict[str, Any]]) -> str:
    """Records of noise alone in which the program finds any line."""
    body = [[row["cell"], str(row["tried"]), percent(row["false"])] for row in rows if "false" in row]
    return "Noise alone, with `false_alarm` = 0.01:\n\n" + table([["record", "draws", "with false lines"], *body])


def find(rows: list[dict[str, Any]], peer: str, cell: str) -> dict[str, Any]:
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


def verdict(rows: list[dict[str, Any]]) -> str:
    """Where another tool is better than the program, beyond what the number of draws explains."""
    said = []
    for kind, which in (("Smaller errors of frequency", 0), ("Smaller errors of decay", 1), ("Fewer lines missed", 2)):
        better = [f"{row['peer']} ({row['cell']})" for row in rows if row.get("better_by") and row["better_by"][which] > SURE]
        said.append(f"{kind}: {'; '.join(better) or 'none'}.")
    return (
        f"Better than beamwave by more than {SURE:g} standard deviations of the difference on the same draws (errors where both have "
        "found the line):\n\n" + "\n".join(f"- {line}" for line in said)
    )


def details(rows: list[dict[str, Any]]) -> str:
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
