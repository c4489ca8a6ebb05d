"""beamwave itself, as a user calls it: a scene with a tolerance in, a NetCDF file out.

Two curves: the whole process (start, reading, computing, writing), and of it what the other peers do too, the stages up
to writing, by the result's own `stage_seconds`.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from .peer import Answer, Peer, Setting
from .problem import Problem

PROGRAM = Path(__file__).parents[2] / "build/bin/beamwave"
SCENE = """\
&beam      length = {p.length!r}, diameter = {p.diameter!r}
           density = {p.density!r}, youngs_modulus = {p.youngs_modulus!r} /
&rotation  angular_velocity = {p.angular_velocity!r} /
&impact    mass_ratio = {p.mass_ratio!r} /
&capture   /
&modes     tolerance = {tolerance!r} /
&response  duration = {p.duration!r}, samples = {p.samples}, points = {points} /
"""


def run(scene: str, problem: Problem, tolerance: float) -> tuple[np.ndarray, float, float, float]:
    """Displacement, CPU and wall seconds of the process, and wall seconds of its stages without writing."""
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "peer.nml"
        points = ", ".join(map(repr, problem.points))
        path.write_text(scene.format(p=problem, tolerance=tolerance, points=points))
        words = [os.environ.get("BEAMWAVE", str(PROGRAM)), "run", str(path), "--output", directory, "--quiet"]
        start = time.perf_counter()
        process = subprocess.Popen(words)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        if status != 0:
            raise RuntimeError(f"beamwave ended with {os.waitstatus_to_exitcode(status)}")
        displacement, stages = read(Path(directory) / "peer.nc")
    return displacement, usage.ru_utime + usage.ru_stime, wall, stages


def read(path: Path) -> tuple[np.ndarray, float]:
    """Displacement, and the seconds of all stages but writing."""
    from netCDF4 import Dataset

    with Dataset(path) as result:
        names = result["stage"].flag_meanings.split()
        seconds = dict(zip(names, np.asarray(result["stage_seconds"][:], dtype=float)))
        seconds.pop("write", None)
        return np.asarray(result["displacement"][:]), sum(seconds.values())


def peers_of(scene: str, settings: tuple[Setting, ...], small: tuple[Setting, ...]) -> tuple[Peer, Peer]:
    """The stages alone, and the whole process; in `scene` stand the problem p, points and tolerance."""

    def process(problem: Problem, tolerance: float) -> Answer:
        displacement, processor, wall, _ = run(scene, problem, tolerance)
        return Answer(displacement, processor, wall)

    def stages(problem: Problem, tolerance: float) -> Answer:
        """Their part of the process's wall time is their part of its CPU time."""
        displacement, processor, wall, seconds = run(scene, problem, tolerance)
        return Answer(displacement, processor * seconds / wall, seconds)

    what = "its stages from the scene to the histories", "the same with start-up, reading the scene and writing the file"
    return (
        Peer("beamwave", what[0], stages, settings, small, packages=("netCDF4",)),
        Peer("beamwave, whole process", what[1], process, settings, small, packages=("netCDF4",)),
    )


STAGES, PROCESS = peers_of(SCENE, tuple({"tolerance": 10.0**-power} for power in range(2, 12)), ({"tolerance": 1e-3}, {"tolerance": 1e-6}))
