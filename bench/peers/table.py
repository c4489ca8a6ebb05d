"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

from common.document import pairs, table

from .measure import PEERS
from .summary import seconds_to_reach, text_of_seconds

FIRST = "<!-- peers: bench/peers.sh writes from here -->"
LEVELS = (2e-3, 1e-6, 1e-9, 1e-10)

WORDS = """\
## Against what else one could pick

Made by `bench/peers.sh` ([bench/](../bench/README.md) says how). The paper's beam after the capture (γ = 0.2,
ω = 50 rad/s): displacement at midpoint and tip over {samples} times in {duration:g} s, from the scene's numbers to the
histories. The error is the largest of either history over its own peak (a tolerance is over the larger peak, the
tip's, 2.5 times the midpoint's), against {reference}.
CPU seconds of one thread, medians of up to {rounds} interleaved runs. `beamwave` is its stages without start-up and
files, as the others have none; its whole process has its own row.

![Error against seconds]({picture})
"""


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and tables."""
    rounds = max(row.get("runs", 1) for row in measured["rows"])
    words = WORDS.format(**measured["problem"], reference=measured["reference"], rounds=rounds, picture=picture)
    return "\n\n".join(
        [words.strip(), pairs(measured["machine"]), summary(measured["rows"]), details(measured["rows"])]
    )


def summary(rows: list[dict[str, Any]]) -> str:
    """Seconds that each peer takes to an error, between its sizes by a power law."""
    body = [["peer", "how", *(f"s to {level:.0e}".replace("e-0", "e-") for level in LEVELS), "smallest error"]]
    for peer in PEERS:
        own = [row for row in rows if row["peer"] == peer.name]
        if not own:
            continue
        if "not_measured" in own[0]:
            body.append([peer.name, peer.what, *("not measured" for _ in LEVELS), own[0]["not_measured"]])
            continue
        known = [row for row in own if row["error"] is not None]
        smallest = f"{min(row['error'] for row in known):.1e}" if known else "none"
        times = [text_of_seconds(seconds_to_reach(known, level)) for level in LEVELS]
        body.append([peer.name, peer.what, *times, smallest])
    return table(body)


def details(rows: list[dict[str, Any]]) -> str:
    """Every size."""
    body = [["peer", "size", "error over peak", "CPU s", "runs"]]
    for row in rows:
        if "not_measured" not in row:
            error = "overflow" if row["error"] is None else f"{row['error']:.1e}"
            body.append([row["peer"], row["setting"], error, f"{row['cpu_seconds']:.2g}", str(row["runs"])])
    return table(body)
