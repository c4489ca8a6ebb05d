"""The section of docs/numbers.md, from the measured rows alone."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table

FIRST = "<!-- price: bench/price.sh writes from here -->"
AIM = 0.25  # of the time at hand, for a tenth of the tolerance
COARSE, FINE = 1e-3, 1e-11  # between which the aim is meant

WORDS = """\
## What accuracy costs

Made by `bench/price.sh` ([bench/](../bench/README.md#the-price-of-accuracy) describes it): `beamwave accuracy` on `input/spectrum.nml`,
and on the same scene with a short record. Errors are the largest of the displacement at midpoint and tip over the peak, against a
converged run; the estimate is the run's own. Times are those of the stages up to the histories, medians of interleaved repeats; +/- is
half their interquartile range.

The aim is that from 1e-3 to 1e-11 each further digit costs at most 25 % more time. Down to 1e-5 few modes are summed directly, at a
cost proportional to their number. This is far cheaper than any transform, so that the step to the transform is large.

![Error against seconds]({picture})
"""


def section(measured: dict[str, Any], picture: str) -> str:
    """Text and a table for each scene."""
    parts = [WORDS.format(picture=picture).strip(), measured_with(measured["machine"])]
    for samples, against in measured["against"].items():
        rows = [row for row in measured["rows"] if row["samples"] == int(samples)]
        parts += [f"{int(samples)} samples. {summary(rows)} {trust(against)}", details(rows, against["converged_error"])]
    return "\n\n".join(parts)


def asked(rows: list[dict[str, Any]]) -> dict[float, dict[str, Any]]:
    """The timed rows by tolerance."""
    return {row["tolerance"]: row for row in rows if row["ladder"] == "tolerance" and "seconds" in row}


def summary(rows: list[dict[str, Any]]) -> str:
    """What a digit costs between the two ends of the aim."""
    timed = asked(rows)
    ends = [timed[end]["seconds"] for end in (COARSE, FINE) if end in timed]
    if len(ends) < 2:
        return ""
    steps = [row["digit_growth"] for tolerance, row in timed.items() if FINE < tolerance <= COARSE and "digit_growth" in row]
    mean = (ends[1] / ends[0]) ** (1.0 / 8.0) - 1.0
    return (
        f"From 1e-3 to 1e-11 a digit costs {mean:+.0%} on average and {max(steps):+.0%} at most, where the aim is "
        f"{AIM:+.0%}; all eight together {ends[1] / ends[0]:.2g} times the time of 1e-3."
    )


def trust(against: dict[str, float]) -> str:
    """How good the converged run is."""
    return f"The converged run's error is estimated at {against['converged_error']:.1e}."


def details(rows: list[dict[str, Any]], resolved: float) -> str:
    """Every rung that was timed."""
    body = [["requested", "modes", "true error", "estimate", "ratio", "ms", "+/-", "modes %", "events %", "response %", "next digit"]]
    for row in rows:
        if "seconds" in row:
            body.append(rung(row, resolved))
    return table(body)


def rung(row: dict[str, Any], resolved: float) -> list[str]:
    """Its cells."""
    tolerance = f"{row.get('tolerance', 0.0):.0e}".replace("e-0", "e-")
    name = {"counts": f"{row['modes']} before and after"}
    measured = row["error"] > resolved
    share = {stage: 100.0 * seconds / sum(row["stages"].values()) for stage, seconds in row["stages"].items()}
    step = ""
    if "digit_growth" in row:  # a price below zero is noise too: a finer tolerance never sums fewer modes
        step = "within noise"
        if row["digit_seconds"] > row["digit_noise"]:
            step = f"{1e3 * row['digit_seconds']:+.2g} ms, {row['digit_growth']:+.0%}"
    return [
        name.get(row["ladder"], f"tolerance {tolerance}"),
        str(row["modes"]),
        f"{row['error']:.1e}" if measured else f"<{resolved:.1e}",
        f"{row['estimate']:.1e}",
        f"{row['estimate'] / row['error']:.2g}" if measured else "–",
        f"{1e3 * row['seconds']:.3g}",
        f"{500.0 * (row['upper'] - row['lower']):.2g}",
        *(f"{share[stage]:.0f}" for stage in ("modes", "events", "response")),
        step,
    ]
