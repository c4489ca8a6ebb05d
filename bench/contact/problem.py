"""What every peer is asked for: the paper's beam at rest, whose tip a mass of 1 kg strikes through a linear stop."""

from __future__ import annotations

from dataclasses import dataclass

import peers.problem


@dataclass(frozen=True)
class Problem(peers.problem.Problem):
    """The mass comes with 1 m/s, leaves, and meets the tip a second time within the record. SI units."""

    samples: int = 1000
    duration: float = 0.05
    mass: float = 1.0
    stiffness: float = 1e6
    mass_ratio: float = 0.0  # nothing stays on the beam
    angular_velocity: float = 0.0
