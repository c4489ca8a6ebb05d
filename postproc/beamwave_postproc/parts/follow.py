"""Modes followed through a sweep: the same motion keeps its curve where the order by frequency changes."""

from __future__ import annotations

import numpy as np
import xarray as xr

NOWHERE = 1e6  # cost of joining a mode to one that is not there


def eigenvalues(ds: xr.Dataset) -> np.ndarray:
    """λ = β² (case, mode) in rad² s⁻², negative where a mode grows; NaN where a mode is not known.

    Of a damped mode that of the undamped one, as far as its growth rate tells.
    """
    beta = ds["angular_frequency"].values
    rate = ds["growth_rate"].values if "growth_rate" in ds else np.zeros(beta.shape)
    return np.where(np.isfinite(beta), beta**2 + np.nan_to_num(rate) ** 2, np.where(rate > 0.0, -(rate**2), np.nan))


def followed(ds: xr.Dataset, along: np.ndarray) -> np.ndarray:
    """Index into `mode` (case, branch): the branch of number b goes on from mode b of the first case.

    `along` ascends with the cases. Where `mode_shape` is there the shapes decide that are most alike, by their modal
    assurance criterion; elsewhere the eigenvalue, which goes on as its last two values say.
    """
    from scipy.optimize import linear_sum_assignment  # here, since few pictures need it and it takes 0.6 s to import

    values = eigenvalues(ds)
    shapes = ds["mode_shape"].values if "mode_shape" in ds else None
    order = np.tile(np.arange(values.shape[1]), (values.shape[0], 1))
    for case in range(1, len(order)):
        cost = _distance(_expected(values, order, along, case), values[case])
        if shapes is not None:
            cost = 1e-3 * cost + _unlike(shapes[case - 1][order[case - 1]], shapes[case])
        order[case] = linear_sum_assignment(np.where(np.isfinite(cost), cost, NOWHERE))[1]
    return order


def _expected(values: np.ndarray, order: np.ndarray, along: np.ndarray, case: int) -> np.ndarray:
    """Eigenvalue of each branch at `case`, straight on from the two cases before it."""
    last = values[case - 1][order[case - 1]]
    if case < 2 or along[case - 1] == along[case - 2]:
        return last
    before = values[case - 2][order[case - 2]]
    step = (along[case] - along[case - 1]) / (along[case - 1] - along[case - 2])
    return np.where(np.isfinite(before), last + step * (last - before), last)


def _distance(expected: np.ndarray, found: np.ndarray) -> np.ndarray:
    """How far each eigenvalue `found` is from each `expected`, over their size: (branch, mode)."""
    size = np.abs(expected[:, None]) + np.abs(found[None, :])
    return np.abs(expected[:, None] - found[None, :]) / np.maximum(size, np.finfo(float).tiny)


def _unlike(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """One less the modal assurance criterion of each pair of shapes (mode, place); NaN for a shape that is fill."""
    products = before @ after.T
    sizes = (before**2).sum(axis=1)[:, None] * (after**2).sum(axis=1)[None, :]
    with np.errstate(invalid="ignore", divide="ignore"):
        return 1.0 - products**2 / sizes
