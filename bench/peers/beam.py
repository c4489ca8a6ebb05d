"""What every peer is asked for, and the beam's modes in numpy, in forms that keep their digits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

NEWTON_ALL = 8  # at most, from the start of mode 1, the worst, to rounding at any mass ratio of the paper
NEWTON_HIGH = 2
HIGH = 14  # from this mode on sech α is below rounding


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


def roots(count: int, gamma: float) -> np.ndarray:
    """Eq. 19: Newton on the scaled frequency equation for the low modes, on its limit for the others."""
    low = low_roots(min(count, HIGH), gamma)
    k = np.arange(HIGH + 1, count + 1)
    base = (k - 0.75) * np.pi
    delta = 1 / (1 + 2 * gamma * base)  # tan δ = 1/(1 + 2γα), α = (k − ¾)π + δ
    for _ in range(NEWTON_HIGH):
        below = 1 + 2 * gamma * (base + delta)
        delta -= (delta - np.arctan(1 / below)) / (1 + 2 * gamma / (1 + below**2))
    return np.concatenate([low, base + delta])


def low_roots(count: int, gamma: float) -> np.ndarray:
    """Eq. 19 over cosh α."""
    alpha = (np.arange(1, count + 1) - 0.75) * np.pi
    alpha = alpha + np.arctan(1 / (1 + 2 * gamma * alpha))
    alpha[0] = (3 / (gamma + 33 / 140)) ** 0.25
    for _ in range(NEWTON_ALL):
        s, c, t = np.sin(alpha), np.cos(alpha), np.tanh(alpha)
        sech = 1 / np.cosh(alpha)
        value = sech + c + alpha * gamma * (c * t - s)
        slope = (1 + gamma) * (c * t - s) - 2 * alpha * gamma * s * t - t * value
        step = value / slope
        alpha = alpha - step
        if np.abs(step).max() < 1e-14 * alpha[-1]:
            break
    return alpha


def amplitudes(problem: Problem, alpha: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each mode at each point (points, modes), and frequencies: the motion is Σ amplitude · sin βt."""
    tip, mass = tips_and_masses(alpha, problem.mass_ratio)
    beta = problem.frequencies(alpha)
    modal = problem.mass_ratio * tip / (mass * beta)
    return shapes(alpha, np.array(problem.points)) * modal, beta


def tips_and_masses(alpha: np.ndarray, gamma: float) -> tuple[np.ndarray, np.ndarray]:
    """Φ(1), and the modal mass over the beam's."""
    decayed = np.exp(-alpha)
    s, c = np.sin(alpha), np.cos(alpha)
    sinh, cosh = (1 - decayed**2) / 2, (1 + decayed**2) / 2  # times e^−α
    below = s * decayed + sinh
    tip = -2 * (decayed + c * cosh) / (alpha * gamma * below)
    return tip, (1 + gamma) * tip**2 / 4 + 2 * (decayed + c * cosh) * s * sinh / below**2


def shapes(alpha: np.ndarray, places: np.ndarray | float) -> np.ndarray:
    """Eq. 18 with one decaying exponential from either end, (places, modes)."""
    decayed, s, c = np.exp(-alpha), np.sin(alpha), np.cos(alpha)
    below = s * decayed + (1 - decayed**2) / 2
    sigma = (c * decayed + (1 + decayed**2) / 2) / below
    growing = (s - c - decayed) / below  # (1 − σ)e^α
    angle = np.multiply.outer(places, alpha)
    ends = (1 + sigma) * np.exp(-angle) + growing * np.exp(angle - alpha)
    return np.cos(angle) - sigma * np.sin(angle) - ends / 2
