"""The answer that all are measured against: modes and mass integrated by DOP853 in contact (`../tests/scenes/contact_reference.py`), with no
line of beamwave in it. Half as many modes show what is missing."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from peers.reference import error

from .problem import Problem

sys.path.insert(0, str(Path(__file__).parents[2] / "tests/scenes"))

MODES = 160


def reference(problem: Problem, modes: int = MODES) -> tuple[np.ndarray, float]:
    """Displacement (points, samples), m, and the error of half as many modes against it."""
    few, exact = (displacement_of(problem, count) for count in (modes // 2, modes))
    return exact, error(few, exact)


def displacement_of(problem: Problem, modes: int) -> np.ndarray:
    import contact_reference

    blow = contact_reference.Blow(
        length=problem.length,
        mass_per_length=problem.density * problem.area,
        bending_stiffness=problem.youngs_modulus * problem.second_moment,
        modes=modes,
        mass=problem.mass,
        position=1.0,
        speed=1.0,
        stiffness=problem.stiffness,
        exponent=1.0,
        contact_damping=0.0,
        ratio=0.0,
        omega=0.0,
        in_plane=True,
        points=list(problem.points),
        times=problem.times,
        duration=problem.duration,
        most_contacts=50,
    )
    return np.array(contact_reference.follow(blow).displacement).T
