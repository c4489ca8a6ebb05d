"""Time and memory of a run against modes, samples and points."""

from __future__ import annotations

from operator import itemgetter
from typing import Any

from common import growing
from common.bench import Bench, Measured
from common.growing import Axis, megabytes

BOUND_FACTOR, BOUND_BYTES = 2, 200e6  # memory stays below twice the result and this

BASE = """\
&beam      length = 1, diameter = 0.037, density = 7870, youngs_modulus = 2e11 /
&rotation  angular_velocity = 50 /
&impact    mass_ratio = 0.2 /
&capture   /
"""


def counted(before: str, n: int) -> str:
    """A scene with so many modes."""
    return f"{BASE}&modes before = {before}, after = {n} /\n&response duration = 1, samples = 4096 /\n"


def tolerated(response: str) -> str:
    """A scene with a tolerance."""
    return f"{BASE}&modes tolerance = 1e-6 /\n&response duration = 1, {response} /\n"


def places(n: int) -> str:
    """So many points."""
    return ", ".join(f"{(i + 1) / n:.9g}" for i in range(n))


AXES = (
    Axis(
        "modes",
        "2 points, 4096 samples; one mode before the capture",
        (1000, 10_000, 100_000, 1_000_000, 3_000_000, 10_000_000),
        (100, 1000),
        lambda n: counted("1", n),
    ),
    Axis(
        "modes before and after",
        "2 points, 4096 samples",
        (100, 1000, 10_000, 100_000, 1_000_000, 3_000_000, 10_000_000),
        (10, 100),
        lambda n: counted(f"{n}", n),
    ),
    Axis(
        "samples",
        "2 points, tolerance 1e-6",
        [2**power for power in range(10, 25, 2)],
        (256, 1024),
        lambda n: tolerated(f"samples = {n}"),
    ),
    Axis(
        "points",
        "65 536 samples, tolerance 1e-6",
        (1, 3, 10, 30, 100, 300, 1000),
        (1, 10),
        lambda n: tolerated(f"samples = 65536, points = {places(n)}"),
    ),
)

WORDS = """\
## How time and memory grow

Made by `bench/growth.sh` ([bench/](../bench/README.md#growth) describes it). Each size is a run of `beamwave run` as a process of
its own. The tables give its CPU seconds, medians of up to {rounds} interleaved runs, and its peak memory. The first table gives
the power of the size to which a cost grows, from the largest {largest} sizes without start-up. The bound of the memory is
twice the result plus 200 MB.

![Time and memory against modes, samples and points](pictures/growth.png)
"""

COLUMNS = (  # what grows, and words of each curve beside its slope
    ("Modes", {"modes": "1 before, all after", "modes before and after": "as many before"}),
    ("Samples", {"samples": ""}),
    ("Points", {"points": ""}),
)


def bound(row: dict[str, Any]) -> float:
    """Bytes that a run may take."""
    return BOUND_FACTOR * row["result_bytes"] + BOUND_BYTES


def section(measured: Measured) -> list[str]:
    """Text and tables."""
    words = WORDS.format(rounds=max(row["runs"] for row in measured["rows"]), largest=growing.LARGEST)
    part = {"largest memory over its bound": lambda rows: f"{max(row['memory_bytes'] / bound(row) for row in rows):.2f}"}
    memory = {"memory MB": "memory_bytes", "result MB": "result_bytes"}
    sizes = {head: megabytes(itemgetter(name)) for head, name in memory.items()}
    return growing.section(measured, words, AXES, part, {**sizes, "bound MB": megabytes(bound)})


BENCH = Bench(
    "growth",
    "time and memory of a run",
    lambda options: {"rows": growing.measure(AXES, options.small)},
    section,
    lambda measured: growing.draw(measured["rows"], COLUMNS, bound, "2 × result + 200 MB"),
)
