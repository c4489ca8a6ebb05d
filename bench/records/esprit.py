"""Plain ESPRIT: the signal's subspace of a Hankel matrix of all sensors, and the shift within it by total least squares."""

from __future__ import annotations

import time

import numpy as np
from scipy.linalg import eigh, svd

from .cells import Cell, Draw, lines_of
from .tool import Lines, Tool, of_poles, only_even


def estimate(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
    """One record after the other."""
    start = time.process_time()
    found = [of_poles(poles(draw.values, 2 * lines_of(cell))) for draw in draws]
    return found, time.process_time() - start


def poles(values: np.ndarray, order: int) -> np.ndarray:
    """z of the model of that order; two thirds of the record are the matrix's columns, as is best for one line."""
    samples, _ = values.shape
    rows = samples // 3
    blocks = [np.lib.stride_tricks.sliding_window_view(column, samples - rows + 1) for column in values.T]
    gram = sum(block @ block.T for block in blocks)
    _, space = eigh(gram, subset_by_index=(rows - order, rows - 1))
    _, _, right = svd(np.hstack([space[:-1], space[1:]]), full_matrices=False)
    upper, lower = right.T[:order, order:], right.T[order:, order:]
    return np.linalg.eigvals(-upper @ np.linalg.inv(lower))


TOOL = Tool("plain ESPRIT", "the number of lines", estimate, only_even, ("scipy",))
