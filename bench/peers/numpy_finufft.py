"""The modal sum by FINUFFT: both real histories in one complex transform of type 1."""

from __future__ import annotations

import numpy as np

from .modes import amplitudes, roots
from .peer import Peer, timed
from .problem import Problem


@timed
def solve(problem: Problem, modes: int, eps: float) -> np.ndarray:
    """Sum `modes` modes to a relative accuracy of about `eps`, two points at a time."""
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


SIZES = (
    (10, 1e-4),
    (30, 1e-5),
    (100, 1e-6),
    (300, 1e-7),
    (1000, 1e-9),
    (3000, 1e-10),
    (8000, 1e-11),
    (20000, 1e-12),
    (60000, 1e-13),
)

PEER = Peer(
    "numpy + FINUFFT",
    "the same modes; one non-uniform FFT for both points",
    solve,
    settings=tuple({"modes": modes, "eps": eps} for modes, eps in SIZES),
    small=({"modes": 10, "eps": 1e-3}, {"modes": 100, "eps": 1e-6}),
    packages=("finufft",),
)
