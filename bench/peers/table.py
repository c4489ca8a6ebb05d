"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table

from .measure import PEERS
from .peer import Peer
from .summary import seconds_to_reach, text_of_seconds

FIRST = "<!-- peers: bench/peers.sh writes from here -->"
LEVELS = (2e-3, 1e-6, 1e-9, 1e-10)

WORDS = """\
## Comparison with other methods

Made by `bench/peers.sh` ([bench/](../bench/README.md#the-peers) describes it). All compute the same quantity: the displacement of the paper's
beam after the capture (γ = 0.2, ω = 50 rad/s) at midpoint and tip, at {samples} times in {duration:g} s, from the scene's
numbers to the histories. Times are CPU seconds of one thread, medians of up to {rounds} interleaved runs. The row `beamwave` counts
its stages without start-up and files, which the others do not have; the whole process has a row of its own.

The error is the largest of either history over its own peak. (A tolerance refers to the larger peak, that of the tip, which is
2.5 times that of the midpoint.) The reference is {reference}.

![Error against seconds]({picture})
"""


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and tables."""
    rounds = max(row.get("runs", 1) for row in measured["rows"])
    words = WORDS.format(**measured["problem"], reference=measured["reference"], rounds=rounds, picture=picture)
    about, rows = measured_with(measured["machine"]), measured["rows"]
    return "\n\n".join([words.strip(), about, summary(rows, PEERS, LEVELS), "All sizes:", details(rows)])


def summary(rows: list[dict[str, Any]], peers: tuple[Peer, ...], levels: tuple[float, ...]) -> str:
    """Seconds that each peer takes to an error, between its sizes by a power law."""
    body = [["peer", "how", *(f"s to {level:.0e}".replace("e-0", "e-") for level in levels), "smallest error"]]
    for peer in peers:
        own = [row for row in rows if row["peer"] == peer.name]
        if not own:
            continue
        if "not_measured" in own[0]:
            body.append([peer.name, peer.what, *("not measured" for _ in levels), own[0]["not_measured"]])
            continue
        known = [row for row in own if row["error"] is not None]
        smallest = f"{min(row['error'] for row in known):.1e}" if known else "none"
        times = [text_of_seconds(seconds_to_reach(known, level)) for level in levels]
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
