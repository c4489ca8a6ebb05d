"""The three jobs: the same cases for the program, as a scene, and for numpy, as numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

LENGTH, DIAMETER, DENSITY, MODULUS = 1.0, 0.037, 7870.0, 2.0e11
POINTS = (0.4, 0.9)  # without midpoint and tip no waves are measured in the spectrum: numpy does not do that either


@dataclass(frozen=True)
class Job:
    """What each case is asked for."""

    name: str
    what: str
    modes: int
    cases: int
    samples: int = 0
    duration: float = 0.2
    spectrum: bool = False
    more: str = ""  # groups that the scene has beside these

    def grid(self, cases: int) -> list[tuple[float, float]]:
        """(ω, γ) of every case, γ varying slowest; the same numbers as in the scene."""
        speeds = np.linspace(0.0, 60.0, cases // 10)
        return [(speed, ratio) for ratio in np.linspace(0.1, 1.0, 10) for speed in speeds]

    def scene(self, cases: int) -> str:
        """The same as a namelist."""
        text = f"""
&beam length = {LENGTH}, diameter = {DIAMETER}, density = {DENSITY}, youngs_modulus = {MODULUS} /
&rotation plane = 'in' /
&impact approach_velocity = 1.0, profile_points = 2 /
&capture /
&modes before = {self.modes}, after = {self.modes} /
&sweep parameter = 'impact%mass_ratio', first = 0.1, last = 1.0, count = 10 /
&sweep parameter = 'rotation%angular_velocity', first = 0.0, last = 60.0, count = {cases // 10} /
"""
        if self.samples:
            points = ", ".join(map(str, POINTS))
            text += f"&response duration = {self.duration}, samples = {self.samples}, points = {points} /\n"
        return text + ("&spectrum /\n" if self.spectrum else "") + self.more

    def words(self, directory: Path, cases: int) -> list[Any]:
        """To run the sweep anew: a result that is there would be nothing to do."""
        scene = directory / f"{self.name}.nml"
        scene.write_text(self.scene(cases))
        (directory / f"{self.name}.nc").unlink(missing_ok=True)
        return ["run", scene, "--output", directory, "--quiet"]


JOBS = [
    Job("frequencies", "frequencies and wave velocities of 20 modes", modes=20, cases=10_000),
    Job("histories", "with histories of 4096 samples at two points, 40 modes", modes=40, cases=5_000, samples=4096),
    Job("spectra", "with amplitude spectra of these", modes=40, cases=5_000, samples=4096, spectrum=True),
]
