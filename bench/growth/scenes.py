"""The scenes of the growth bench: one axis grows, the others stay."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

BASE = """\
&beam      length = 1, diameter = 0.037, density = 7870, youngs_modulus = 2e11 /
&rotation  angular_velocity = 50 /
&impact    mass_ratio = 0.2 /
&capture   /
"""


@dataclass(frozen=True)
class Axis:
    """What grows: its sizes, and what the scene has besides."""

    name: str
    besides: str  # for the figure and the table
    sizes: tuple[int, ...]
    small: tuple[int, ...]
    groups: str  # with {n}

    def scene(self, size: int) -> str:
        """A scene of this size."""
        points = ", ".join(f"{(i + 1) / size:.9g}" for i in range(size)) if "{points}" in self.groups else ""
        return BASE + self.groups.format(n=size, points=points)

    def prepare(self, directory: Path, size: int) -> None:
        """Nothing lies beside the scene."""


AXES = (
    Axis(
        "modes",
        "2 points, 4096 samples; one mode before the capture",
        (1000, 10_000, 100_000, 1_000_000, 3_000_000, 10_000_000),
        (100, 1000),
        "&modes before = 1, after = {n} /\n&response duration = 1, samples = 4096 /\n",
    ),
    Axis(
        "modes before and after",
        "2 points, 4096 samples",
        (100, 1000, 10_000, 100_000, 1_000_000, 3_000_000, 10_000_000),
        (10, 100),
        "&modes before = {n}, after = {n} /\n&response duration = 1, samples = 4096 /\n",
    ),
    Axis(
        "samples",
        "2 points, tolerance 1e-6",
        tuple(2**power for power in (10, 12, 14, 16, 18, 20, 22, 24)),
        (256, 1024),
        "&modes tolerance = 1e-6 /\n&response duration = 1, samples = {n} /\n",
    ),
    Axis(
        "points",
        "65 536 samples, tolerance 1e-6",
        (1, 3, 10, 30, 100, 300, 1000),
        (1, 10),
        "&modes tolerance = 1e-6 /\n&response duration = 1, samples = 65536, points = {points} /\n",
    ),
)
