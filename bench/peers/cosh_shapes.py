"""The modes as a textbook prints them: cosh and sinh as they stand, roots by Brent, masses by quadrature."""

from __future__ import annotations

import numpy as np

from .numpy_products import sum_of_sines
from .peer import Peer, timed
from .problem import Problem

STEPS = 2001  # of Simpson's rule for the modal mass


@timed
def solve(problem: Problem, modes: int) -> np.ndarray:
    """Sum `modes` modes; not a number where cosh overflows."""
    from scipy.integrate import simpson
    from scipy.optimize import brentq

    gamma = problem.mass_ratio
    grid = np.linspace(0, 1, STEPS)
    with np.errstate(all="ignore"):
        try:
            alpha = np.array([brentq(frequency_equation, *bracket(k), args=(gamma,)) for k in range(1, modes + 1)])
        except ValueError:  # cosh has overflowed
            return np.full((len(problem.points), problem.samples), np.nan)
        tip = shape(alpha, 1.0)
        mass = np.array([simpson(shape(a, grid) ** 2, x=grid) for a in alpha]) + gamma * tip**2
        weights = np.array([shape(alpha, xi) for xi in problem.points]) * gamma * tip / mass
        beta = problem.frequencies(alpha)
        return sum_of_sines(weights / beta, beta, problem.samples, problem.duration / problem.samples)


def bracket(k: int) -> tuple[float, float]:
    """An interval around root k of Eq. 19."""
    return (0.1, 2.0) if k == 1 else ((k - 1) * np.pi + np.pi / 4 - 0.1, (k - 0.5) * np.pi + 0.1)


def frequency_equation(alpha: float, gamma: float) -> float:
    """Eq. 19."""
    s, c, sh, ch = np.sin(alpha), np.cos(alpha), np.sinh(alpha), np.cosh(alpha)
    return float(1 + c * ch + alpha * gamma * (c * sh - s * ch))


def shape(alpha: np.ndarray | float, xi: np.ndarray | float) -> np.ndarray:
    """Eq. 18."""
    angle = alpha * np.asarray(xi)
    sigma = (np.cos(alpha) + np.cosh(alpha)) / (np.sin(alpha) + np.sinh(alpha))
    return np.cos(angle) - np.cosh(angle) - sigma * (np.sin(angle) - np.sinh(angle))


PEER = Peer(
    "textbook cosh shapes",
    "cosh and sinh as printed, Brent's method, Simpson's rule; the sum in matrix products",
    solve,
    settings=tuple({"modes": n} for n in (3, 5, 8, 11, 14, 20, 50, 100, 200, 230)),
    small=({"modes": 5}, {"modes": 230}),
    packages=("scipy",),
)
