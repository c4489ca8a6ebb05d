"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table

from .scenes import MODES, SAMPLES

FIRST = "<!-- effects: bench/effects.sh writes from here -->"

WORDS = """\
## What each effect costs

Made by `bench/effects.sh` ([bench/](../bench/README.md#effects) describes it). The paper's scene (γ = 0.2, ω = 50 rad/s, {modes} modes
before and after the capture, {samples} samples at midpoint and tip) is run alone and with one additional effect. Valgrind counts the
instructions of the whole run; those of `beamwave --version` are subtracted. Times are those of all stages except writing, medians of
{runs} interleaved runs. The procedures of an absent effect are never called;
`tests/scenes/test_absent_effects.py` checks each of them.

![Instructions and seconds with each effect]({picture})
"""


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and table."""
    runs = max(row["runs"] for row in measured["rows"])
    words = WORDS.format(modes=MODES, samples=SAMPLES, runs=runs, picture=picture)
    return "\n\n".join([words.strip(), measured_with(measured["machine"]), costs(measured["rows"])])


def costs(rows: list[dict[str, Any]]) -> str:
    """One line for each scene."""
    known = {row["variant"]: row for row in rows}
    body = [["scene", "modes by", "million instructions", "times as many", "ms", "times as long"]]
    for row in rows:
        beside = known[row["beside"]]
        body.append(
            [
                row["variant"],
                row["method"],
                "–" if row["instructions"] is None else f"{row['instructions'] / 1e6:.3g}",
                times(row["instructions"], beside["instructions"]),
                f"{row['seconds'] * 1e3:.3g}",
                times(row["seconds"], beside["seconds"]),
            ]
        )
    return table(body)


def times(value: float | None, beside: float | None) -> str:
    """A ratio; a dash where one of the two is not known."""
    return f"{float(f'{value / beside:.2g}'):g}" if value and beside else "–"
