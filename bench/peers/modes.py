"""Modes of the beam with the mass in numpy, in forms that survive: what a careful user writes in twenty lines."""

from __future__ import annotations

import numpy as np

from .problem import Problem

NEWTON_ALL = 6  # from the start of mode 1, the worst, to rounding at any mass ratio of the paper
NEWTON_HIGH = 2
HIGH = 14  # from this mode on sech α is below rounding


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
        alpha = alpha - value / slope
    return alpha


def amplitudes(problem: Problem, alpha: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each mode at each point (points, modes), and frequencies: the motion is Σ amplitude · sin βt."""
    gamma = problem.mass_ratio
    decayed = np.exp(-alpha)
    s, c = np.sin(alpha), np.cos(alpha)
    sinh, cosh = (1 - decayed**2) / 2, (1 + decayed**2) / 2  # times e^−α
    below = s * decayed + sinh
    tip = -2 * (decayed + c * cosh) / (alpha * gamma * below)
    mass = (1 + gamma) * tip**2 / 4 + 2 * (decayed + c * cosh) * s * sinh / below**2
    beta = problem.frequencies(alpha)
    modal = gamma * tip / (mass * beta)
    sigma = (c * decayed + cosh) / below
    growing = (s - c - decayed) / below  # (1 − σ)e^α
    shapes = [shape(alpha, xi, sigma, growing) for xi in problem.points]
    return np.array(shapes) * modal, beta


def shape(alpha: np.ndarray, xi: float, sigma: np.ndarray, growing: np.ndarray) -> np.ndarray:
    """Eq. 18 with one decaying exponential from either end."""
    angle = alpha * xi
    ends = (1 + sigma) * np.exp(-angle) + growing * np.exp(angle - alpha)
    return np.cos(angle) - sigma * np.sin(angle) - ends / 2
