"""What every peer is asked for: the paper's beam after it caught the mass, as the continuum answers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Problem:
    """A beam that stands still in its rotating frame is struck by a mass of 1 m/s, which stays. SI units."""

    samples: int = 65536
    duration: float = 1.0
    points: tuple[float, ...] = (0.5, 1.0)  # x over the length
    mass_ratio: float = 0.2
    angular_velocity: float = 50.0
    length: float = 1.0
    diameter: float = 0.037
    density: float = 7870.0
    youngs_modulus: float = 2e11

    @property
    def area(self) -> float:
        """Of the solid circle, m²."""
        return float(np.pi * self.diameter**2 / 4)

    @property
    def second_moment(self) -> float:
        """Of the solid circle, m⁴."""
        return float(np.pi * self.diameter**4 / 64)

    @property
    def h(self) -> float:
        """sqrt(EI/(ρA)), m²/s."""
        return float(self.diameter / 4 * np.sqrt(self.youngs_modulus / self.density))

    @property
    def times(self) -> np.ndarray:
        """The stored times, s."""
        return np.arange(self.samples) * (self.duration / self.samples)

    def frequencies(self, alpha: np.ndarray) -> np.ndarray:
        """Eq. 30 for ᾱ = P̄ l, rad/s."""
        return np.sqrt((self.h * (alpha / self.length) ** 2) ** 2 - self.angular_velocity**2)
