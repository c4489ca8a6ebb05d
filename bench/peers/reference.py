"""The answer that all are measured against: a plain modal sum of many modes, with no line of beamwave in it.

Roots and phases in extended precision (80 bits), amplitudes in double, the sum in matrix products. It checks itself
twice: half as many modes give the same, and at a few times so do 50 digits of mpmath from plain definitions.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np

from .beam import Problem, amplitudes, roots
from .comparison import error

MODES = 400_000
BLOCK = 4096
WIDE = np.longdouble
DIGITS_OF_CHECK = 50
MODES_OF_CHECK = 120


def reference(problem: Problem, modes: int = MODES) -> tuple[np.ndarray, float]:
    """Displacement (points, samples) of `modes` modes, m, and the error of half as many against it."""
    alpha = wide_roots(modes, problem.mass_ratio)
    weights, _ = amplitudes(problem, alpha.astype(float))
    h = WIDE(problem.diameter) / 4 * np.sqrt(WIDE(problem.youngs_modulus) / WIDE(problem.density))
    beta = np.sqrt((h * alpha**2) ** 2 - WIDE(problem.angular_velocity) ** 2)
    half = modes // 2
    first = summed(problem, weights[:, :half], beta[:half])
    exact = first + summed(problem, weights[:, half:], beta[half:])
    return exact, error(first, exact)


def wide_roots(modes: int, gamma: float) -> np.ndarray:
    """Eq. 19 by Newton in extended precision, from the roots in double."""
    alpha = roots(modes, gamma).astype(WIDE)
    wide_gamma = WIDE(gamma)
    for _ in range(2):
        s, c, t, decayed = np.sin(alpha), np.cos(alpha), np.tanh(alpha), np.exp(-alpha)
        value = 2 * decayed / (1 + decayed**2) + c + alpha * wide_gamma * (c * t - s)
        slope = (1 + wide_gamma) * (c * t - s) - 2 * alpha * wide_gamma * s * t - t * value
        alpha = alpha - value / slope
    return alpha


def summed(problem: Problem, weights: np.ndarray, beta: np.ndarray) -> np.ndarray:
    """Σ weights sin βt over a grid of coarse and fine times, small terms first."""
    inner = 1 << (max(problem.samples - 1, 1).bit_length() + 1) // 2
    outer = -(-problem.samples // inner)
    step = WIDE(problem.duration) / problem.samples
    total = np.zeros((len(weights), outer, inner))
    for first in reversed(range(0, len(beta), BLOCK)):
        part = slice(first, first + BLOCK)
        coarse = turned(beta[part], np.arange(outer) * (inner * step)).T
        fine = turned(beta[part], np.arange(inner) * step)
        for point, weight in enumerate(weights[:, part]):
            total[point] += (np.sin(coarse) * weight) @ np.cos(fine) + (np.cos(coarse) * weight) @ np.sin(fine)
    return total.reshape(len(weights), -1)[:, : problem.samples]


def turned(beta: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Phases (modes, times) less whole turns, in double."""
    turns = np.outer(beta / (2 * WIDE(np.pi) + 2 * WIDE(1.2246467991473532e-16)), times)
    return ((turns - np.rint(turns)) * (2 * np.pi)).astype(float)


def check_digits(problem: Problem) -> float | None:
    """Error of a sum of few modes against 50 digits at three times; None without mpmath."""
    if find_spec("mpmath") is None:
        return None
    import beam
    from mpmath import mpf

    beam.use_digits(DIGITS_OF_CHECK + int(MODES_OF_CHECK * 3))
    paper = beam.PaperBeam(problem.diameter, problem.youngs_modulus, problem.density)
    shapes = [beam.Shape(k, problem.mass_ratio) for k in range(1, MODES_OF_CHECK + 1)]
    few, _ = reference(problem, MODES_OF_CHECK)
    worst = 0.0
    speeds = [mpf(problem.mass_ratio) * shape.tip / shape.modal_mass() for shape in shapes]
    squares = [paper.beta_squared(shape.alpha, problem.angular_velocity) for shape in shapes]
    for j in (1, problem.samples // 3, problem.samples - 1):
        time = mpf(problem.duration) * j / problem.samples
        waves = [q * beam.sine_like(b, time) for q, b in zip(speeds, squares)]
        for row, xi in enumerate(problem.points):
            exact = sum(wave * shape.value(mpf(xi)) for wave, shape in zip(waves, shapes))
            worst = max(worst, abs(float(exact - mpf(few[row, j]))) / float(np.max(np.abs(few[row]))))
    return worst
