"""Random cantilevers: modes of cubic finite elements, and how they move when they are struck, shaken or let go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from peers.hermite import MASS, STIFFNESS, assemble
from scipy.linalg import eigh

ELEMENTS = 24
MOST_MODES = 6
HIGHEST = 0.45  # of the sampling rate: what lies above is filtered by the recorder
PERIODS = 8  # of the lowest mode in a record, at least


@dataclass(frozen=True)
class Beam:
    """Modes that a record holds."""

    frequencies: np.ndarray  # Hz, ascending
    ratios: np.ndarray  # damping, of the critical
    shapes: np.ndarray  # of unit modal mass, (stations, modes), the stations evenly spaced from root to tip

    def poles(self) -> np.ndarray:
        """−δ + iβ, 1/s."""
        turns = 2 * np.pi * self.frequencies
        return turns * (-self.ratios + 1j * np.sqrt(1 - self.ratios**2))

    def at(self, position: float) -> np.ndarray:
        """Shapes at a place 0 … 1."""
        return np.array([np.interp(position, np.linspace(0, 1, len(self.shapes)), shape) for shape in self.shapes.T])


def modes(clamp: float, tip_mass: float) -> tuple[np.ndarray, np.ndarray]:
    """Wave frequencies λ² and shapes of a cantilever whose root turns against a spring of `clamp` EI/l, with a mass at its tip."""
    h = 1 / ELEMENTS
    scale = np.outer([1, h, 1, h], [1, h, 1, h])
    stiffness = assemble(STIFFNESS * scale / h**3, ELEMENTS, held=1)
    mass = assemble(MASS * scale * h, ELEMENTS, held=1)
    stiffness[0, 0] += clamp
    mass[-2, -2] += tip_mass
    squares, vectors = eigh(stiffness, mass, subset_by_index=(0, MOST_MODES - 1))
    return np.sqrt(squares), np.vstack([np.zeros(MOST_MODES), vectors[1::2]])


def random_beam(random: np.random.Generator, rate: float, duration: float, ratios: tuple[float, float]) -> Beam:
    """A cantilever of random length, section, softness of its clamp and mass at its tip, with two modes or more below the filter."""
    while True:
        length, height = random.uniform(0.15, 1.2), random.uniform(0.002, 0.012)
        squares, shapes = modes(10 ** random.uniform(0.5, 4), random.choice([0.0, random.uniform(0, 1)]))
        frequencies = squares * random.uniform(4600, 5400) * height / np.sqrt(12) / length**2 / (2 * np.pi)
        kept = frequencies < HIGHEST * rate
        if kept.sum() > 1 and frequencies[0] * duration > PERIODS:
            return Beam(frequencies[kept], log_uniform(random, *ratios, kept.sum()), shapes[:, kept])


def log_uniform(random: np.random.Generator, low: float, high: float, size: int | None = None) -> np.ndarray:
    """Numbers whose logarithm is uniform."""
    return np.exp(random.uniform(np.log(low), np.log(high), size))
