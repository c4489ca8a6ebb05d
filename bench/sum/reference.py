"""The same sum at a few samples, term by term in numpy's longdouble: 64 bits of mantissa where the machine has them."""

from __future__ import annotations

import numpy as np

Real = np.longdouble
PI = 4 * np.arctan(Real(1))
CHUNK = 4096  # modes at a time


def roots(n: int, gamma: float) -> np.ndarray:
    """Of the frequency equation divided by γα cosh α, by Newton's method in δ, α = (k − ¾)π + δ."""
    k = np.arange(1, n + 1)
    anchor = (k - Real(0.75)) * PI
    delta = np.arctan(1 / (1 + 2 * gamma * anchor))
    if n > 0:
        delta[0] = (3 / Real(gamma) / (1 + Real("0.2427") / Real(gamma))) ** Real(0.25) - anchor[0]
    sign = np.where(k % 2 == 0, Real(1), Real(-1))
    for _ in range(6):
        alpha = anchor + delta
        u = 1 / (gamma * alpha)
        fall = np.exp(-alpha)
        sech, tau = 2 * fall / (1 + fall**2), 2 * fall**2 / (1 + fall**2)
        edge = np.sqrt(Real(2)) * sign * u * sech
        value = np.sin(delta) * (2 + u - tau) - np.cos(delta) * (u - tau) + edge
        slope = np.cos(delta) * (2 + u - tau) + np.sin(delta) * (u - tau) - edge * (1 / alpha + 1 - tau)
        slope += (sech**2 - u / alpha) * (np.sin(delta) - np.cos(delta))
        delta = delta - value / slope
    return anchor + delta


def terms(n: int, gamma: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, and amplitudes of the sines at midpoint and tip, (2, n)."""
    alpha = roots(n, Real(gamma))
    c, s, fall = np.cos(alpha), np.sin(alpha), np.exp(-alpha)
    cosh, sinh = (1 + fall**2) / 2, (1 - fall**2) / 2  # times e^(−α), as all that follows
    low = s * fall + sinh
    tip = 2 * (c * sinh - s * cosh) / low
    mass = (1 + Real(gamma)) * tip**2 / 4 + 2 * (fall + c * cosh) * s * sinh / low**2
    half = alpha / 2
    sigma = (c * fall + cosh) / low
    rising = (s - c - fall) / low / 2  # (1 − σ)e^α/2
    middle = np.cos(half) - sigma * np.sin(half) - (1 + sigma) / 2 * np.exp(-half) - rising * np.exp(-half)
    drive = gamma * tip / mass / alpha**2
    return alpha**2, np.stack([middle * drive, tip * drive])


def histories(n: int, gamma: float, step: float, samples: np.ndarray) -> np.ndarray:
    """Displacements at the given samples, (2, samples)."""
    beta, amplitude = terms(n, gamma)
    times = Real(step) * samples.astype(Real)
    total = np.zeros((2, len(samples)), Real)
    for first in range(0, n, CHUNK):
        part = slice(first, first + CHUNK)
        total += amplitude[:, part] @ np.sin(np.outer(beta[part], times))
    return total
