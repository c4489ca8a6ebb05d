"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from common.document import measured_with
from peers.table import details, summary

from .peers_here import PEERS

FIRST = "<!-- contact: bench/contact.sh writes from here -->"
LEVELS = (1e-3, 1e-4, 1e-5, 1e-9)

WORDS = """\
## Contact of finite duration: OpenSees and Exudyn

Made by `bench/contact.sh` ([bench/](../bench/README.md#a-contact-that-lasts) describes it). All compute the same problem: a mass of 1 kg strikes the
tip of the paper's beam at 1 m/s through a linear stop of 1e6 N/m, leaves it after 2.6 ms and meets it again. Compared are the displacements of midpoint and
tip at {samples} times in {duration:g} s, with errors and times as [above](#comparison-with-other-methods). The reference is
{reference}.{ratio}

![Error against seconds]({picture})
"""


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and tables."""
    rows = measured["rows"]
    words = WORDS.format(**measured["problem"], reference=measured["reference"], ratio=ratio(rows), picture=picture)
    return "\n\n".join([words.strip(), measured_with(measured["machine"]), summary(rows, PEERS, LEVELS), "All sizes:", details(rows)])


def ratio(rows: list[dict[str, Any]]) -> str:
    """How much larger the smallest error of the others is in the time of the program's whole process; nothing where no other is as fast."""
    known = [row for row in rows if row.get("error") is not None]
    others = {row["peer"] for row in known if not row["peer"].startswith("beamwave")}
    curves = [[row for row in known if row["peer"] == name] for name in others]
    own = [row for row in known if row["peer"] == "beamwave, whole process"]
    found = [min((error_within(curve, row["cpu_seconds"]) for curve in curves), default=np.inf) / row["error"] for row in own]
    found = [value for value in found if np.isfinite(value)]
    if not found:
        return ""
    return (
        " In the time of its whole process, including files, beamwave's error is smaller than the best of the others by a factor of "
        f"{min(found):.0e} to {max(found):.0e}.".replace("e+0", "e")
    )


def error_within(curve: list[dict[str, Any]], seconds: float) -> float:
    """The smallest error that one peer reaches in a time, between its sizes by a power law; infinite where its smallest size takes longer."""
    curve = sorted(curve, key=lambda row: row["cpu_seconds"])
    if seconds < curve[0]["cpu_seconds"]:
        return float("inf")
    errors = np.minimum.accumulate([row["error"] for row in curve])
    return float(np.exp(np.interp(np.log(seconds), np.log([row["cpu_seconds"] for row in curve]), np.log(errors))))
