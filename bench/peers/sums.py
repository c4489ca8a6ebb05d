"""The modal sum in numpy, in three ways: the beam's own modes by matrix products or FINUFFT, or the textbook's."""

from __future__ import annotations

import numpy as np

from .beam import Problem, amplitudes, roots
from .comparison import Peer, timed

BLOCK = 4096  # modes in one product
STEPS = 2001  # of Simpson's rule for the modal mass


def sum_of_sines(weights: np.ndarray, beta: np.ndarray, samples: int, step: float) -> np.ndarray:
    """Σ_k weights[p, k] sin(beta[k] j step) for j = 0 … samples − 1, (points, samples).

    β(aB + b)Δt = βaBΔt + βbΔt: few sines are taken, and BLAS does the rest.
    """
    inner = 1 << (max(samples - 1, 1).bit_length() + 1) // 2
    outer = -(-samples // inner)
    total = np.zeros((len(weights), outer, inner))
    for first in range(0, len(beta), BLOCK):
        part = slice(first, first + BLOCK)
        coarse = np.outer(np.arange(outer) * (inner * step), beta[part])
        fine = np.outer(beta[part], np.arange(inner) * step)
        sines, cosines = np.sin(fine), np.cos(fine)
        coarse_sines, coarse_cosines = np.sin(coarse), np.cos(coarse)
        for point, weight in enumerate(weights[:, part]):
            total[point] += (coarse_sines * weight) @ cosines
            total[point] += (coarse_cosines * weight) @ sines
    return total.reshape(len(weights), -1)[:, :samples]


@timed
def products(problem: Problem, modes: int) -> np.ndarray:
    """Sum `modes` modes by products."""
    weights, beta = amplitudes(problem, roots(modes, problem.mass_ratio))
    return sum_of_sines(weights, beta, problem.samples, problem.duration / problem.samples)


@timed
def transform(problem: Problem, modes: int, eps: float) -> np.ndarray:
    """Sum `modes` modes to a relative accuracy of about `eps`: a transform of type 1 for every two points."""
    import finufft

    weights, beta = amplitudes(problem, roots(modes, problem.mass_ratio))
    phase = np.remainder(beta * (problem.duration / problem.samples), 2 * np.pi)
    # outputs are numbered from −samples/2: the turn by half of them begins the record at 0
    turn = np.exp(1j * (problem.samples // 2) * phase)
    nodes = np.concatenate([phase, -phase])
    displacement = np.empty((len(problem.points), problem.samples))
    for first in range(0, len(weights), 2):
        pair = weights[first] + (1j * weights[first + 1] if first + 1 < len(weights) else 0)
        half = -0.5j * pair  # B sin x = −½i B e^(ix) + ½i B e^(−ix)
        strengths = np.concatenate([half * turn, -half * turn.conj()])
        sums = finufft.nufft1d1(nodes, strengths, problem.samples, eps=eps, isign=1, nthreads=1)
        displacement[first] = sums.real
        if first + 1 < len(weights):
            displacement[first + 1] = sums.imag
    return displacement


@timed
def textbook(problem: Problem, modes: int) -> np.ndarray:
    """Sum modes as printed: roots by Brent, masses by quadrature; not a number where cosh overflows."""
    from scipy.integrate import simpson
    from scipy.optimize import brentq

    gamma = problem.mass_ratio
    grid = np.linspace(0, 1, STEPS)
    with np.errstate(all="ignore"):
        try:
            found = [brentq(frequency_equation, *bracket(k), args=(gamma,)) for k in range(1, modes + 1)]
        except ValueError:  # cosh has overflowed
            return np.full((len(problem.points), problem.samples), np.nan)
        alpha = np.array(found)
        tip = printed_shape(alpha, 1.0)
        mass = np.array([simpson(printed_shape(a, grid) ** 2, x=grid) for a in alpha]) + gamma * tip**2
        weights = np.array([printed_shape(alpha, xi) for xi in problem.points]) * gamma * tip / mass
        beta = problem.frequencies(alpha)
        return sum_of_sines(weights / beta, beta, problem.samples, problem.duration / problem.samples)


def bracket(k: int) -> tuple[float, float]:
    """An interval around root k of Eq. 19."""
    return (0.1, 2.0) if k == 1 else ((k - 1) * np.pi + np.pi / 4 - 0.1, (k - 0.5) * np.pi + 0.1)


def frequency_equation(alpha: float, gamma: float) -> float:
    """Eq. 19."""
    s, c, sh, ch = np.sin(alpha), np.cos(alpha), np.sinh(alpha), np.cosh(alpha)
    return float(1 + c * ch + alpha * gamma * (c * sh - s * ch))


def printed_shape(alpha: np.ndarray | float, xi: np.ndarray | float) -> np.ndarray:
    """Eq. 18."""
    angle = alpha * np.asarray(xi)
    sigma = (np.cos(alpha) + np.cosh(alpha)) / (np.sin(alpha) + np.sinh(alpha))
    return np.cos(angle) - np.cosh(angle) - sigma * (np.sin(angle) - np.sinh(angle))


PEERS = (
    Peer(
        "numpy + FINUFFT",
        "the same modes; one non-uniform FFT for both points",
        transform,
        {"modes": (10, 30, 100, 300, 1000, 3000, 8000, 20000, 60000),
         "eps": (1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)},
        {"modes": (10, 100), "eps": (1e-3, 1e-6)},
        ("finufft",),
    ),
    Peer(
        "numpy, matrix products",
        "the same sum by the addition theorem over a grid of times, in BLAS",
        products,
        {"modes": (10, 30, 100, 300, 1000, 3000, 10000, 30000)},
        {"modes": (10, 30)},
    ),
    Peer(
        "textbook cosh shapes",
        "cosh and sinh as printed, Brent's method, Simpson's rule; the sum in matrix products",
        textbook,
        {"modes": (3, 5, 8, 11, 14, 20, 50, 100, 200, 230)},
        {"modes": (5, 230)},
        ("scipy",),
    ),
)
