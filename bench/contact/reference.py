"""What every peer is asked for, and the answer: modes and mass integrated by DOP853 in contact
(`../tests/scenes/contact_reference.py`), with no line of beamwave in it. Half as many modes show what is missing."""

from __future__ import annotations

from dataclasses import dataclass

import common  # noqa: F401 (finds tests/scenes)
import contact_reference
import numpy as np
import peers.beam
from peers.comparison import error

MODES = 160


@dataclass(frozen=True)
class Problem(peers.beam.Problem):
    """The paper's beam at rest, whose tip a mass strikes through a linear stop: it comes with 1 m/s, leaves, and meets
    the tip a second time within the record. SI units."""

    samples: int = 1000
    duration: float = 0.05
    mass: float = 1.0
    stiffness: float = 1e6
    mass_ratio: float = 0.0  # nothing stays on the beam
    angular_velocity: float = 0.0


def reference(problem: Problem, modes: int = MODES) -> tuple[np.ndarray, float]:
    """Displacement (points, samples), m, and the error of half as many modes against it."""
    few, exact = (displacement_of(problem, count) for count in (modes // 2, modes))
    return exact, error(few, exact)


def displacement_of(problem: Problem, modes: int) -> np.ndarray:
    """The histories of so many modes."""
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
