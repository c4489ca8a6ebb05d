"""The section of docs/numbers.md."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table

FIRST = "<!-- sums: bench/sum.sh writes from here -->"

HEAD = """## Modes and their sum: numpy + FINUFFT

Made by `bench/sum.sh` ([bench/](../bench/README.md#modes-and-their-sum) describes it), in one process on one core. Times are CPU time,
medians of {repeats} interleaved runs. The whole job is roots, shapes at midpoint and tip, and both histories. Errors are those of the
sum at some samples, over the largest displacement, against direct summation in extended precision. *Its way* is the
faster of two ways to use FINUFFT: a transform for each of the two points (`pair`), or one for both points over times of either
sign (`both sides`)."""

COLUMNS = ["modes", "samples", "whole job, ms", "rival, ms", "ratio", "sum alone, ms", "FINUFFT, ms", "ratio", "its way",
           "error", "rival's error"]  # fmt: skip


def section(measured: dict[str, Any]) -> str:
    """A table for every accuracy, and where it was measured."""
    parts = [HEAD.format(repeats=measured["repeats"])]
    for tolerance in dict.fromkeys(row["tolerance"] for row in measured["rows"]):
        rows = [row for row in measured["rows"] if row["tolerance"] == tolerance]
        parts += [f"Accuracy of the sum {tolerance:.0e} of the peak:", table([COLUMNS, *map(cells, rows)])]
    return "\n\n".join([*parts, measured_with(measured["about"])])


def cells(row: dict[str, Any]) -> list[str]:
    """A row as it is shown."""

    def both(ours: str, theirs: str) -> list[str]:
        alone = f"{1e3 * row[ours]:.3g}"
        return [alone, f"{1e3 * row[theirs]:.3g}", f"{row[ours] / row[theirs]:.2f}"] if theirs in row else [alone, "–", "–"]

    size = [str(row["modes"]), f"2^{row['samples'].bit_length() - 1}"]
    errors = [f"{row['error']:.0e}", f"{row['rival_error']:.0e}" if "rival_error" in row else "–"]
    return [*size, *both("job", "rival"), *both("sum", "finufft"), row.get("way", "–"), *errors]
