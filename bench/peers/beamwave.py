"""beamwave itself, as a user calls it: a scene with a tolerance in, a NetCDF file out.

Two curves: the whole process (start, reading, computing, writing), and of it what the other peers do too, the stages up
to writing, by the result's own `stage_seconds`.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from common.measuring import run_scene, stage_seconds

from .comparison import Answer, Peer

SCENE = """\
&beam      length = {p.length!r}, diameter = {p.diameter!r}
           density = {p.density!r}, youngs_modulus = {p.youngs_modulus!r} /
&modes     tolerance = {tolerance!r} /
&response  duration = {p.duration!r}, samples = {p.samples}, points = {points} /
"""


def peers_of(groups: str, finest: int) -> tuple[Peer, Peer]:
    """The stages alone and the whole process with tolerances 1e-2 … 1e-`finest`; `groups` are those of the blow."""

    def run(problem: Any, tolerance: float) -> tuple[Answer, float]:
        """The whole process, and wall seconds of its stages without writing."""
        from netCDF4 import Dataset

        points = ", ".join(map(repr, problem.points))
        with tempfile.TemporaryDirectory() as directory:
            text = (SCENE + groups).format(p=problem, tolerance=tolerance, points=points)
            took = run_scene(Path(directory), text)
            with Dataset(Path(directory) / "scene.nc") as result:
                displacement, stages = np.asarray(result["displacement"][:]), stage_seconds(result)
        return Answer(took.seconds, took.wall, displacement), stages

    def process(problem: Any, tolerance: float) -> Answer:
        return run(problem, tolerance)[0]

    def stages(problem: Any, tolerance: float) -> Answer:
        """Their part of the process's wall time is their part of its CPU time."""
        whole, seconds = run(problem, tolerance)
        return Answer(whole.seconds * seconds / whole.wall, seconds, whole.displacement)

    sizes = {"tolerance": [10.0**-power for power in range(2, finest + 1)]}, {"tolerance": (1e-3, 1e-6)}
    what = "its stages from the scene to the histories", "the same with start-up, reading the scene and writing the file"
    return (
        Peer("beamwave", what[0], stages, *sizes, ("netCDF4",)),
        Peer("beamwave, whole process", what[1], process, *sizes, ("netCDF4",)),
    )
