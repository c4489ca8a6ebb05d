"""First-order indices (Sobol 1993) from any table of independent inputs: random, a Latin hypercube, a Sobol sequence or a grid.

The main effects of all inputs are fitted together, by least squares. What one input does is then no noise to another: noise
comes from the interactions alone, and little is left to subtract, whether the table spreads it as chance does or more evenly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

MOST_TERMS = 12  # of a main effect: more follow a jump little better
MOST_CASES = 2**17  # drawn of more: an index of so many scatters by a few thousandths
CASES_PER_INPUT = 4  # at least, for two terms of each input and as much freedom for what they leave
DEPENDENT = 0.01  # of the mean square of a sum of terms to that of each: independent inputs leave 0.09 or more
DRAWS = 400  # of an input without influence
SEED = 20261127


@dataclass
class Indices:
    """Of each input: the part of the variance that it explains by itself, and what one without influence exceeds in 5 % of draws."""

    first_order: np.ndarray
    by_chance: np.ndarray


def first_order_indices(inputs: np.ndarray, values: np.ndarray) -> Indices:
    """Of `inputs` (inputs, cases) and what came out, `values` (cases); NaN of fewer than four cases for each input, of equal
    values, and where main effects cannot be told apart, as of an input and its square.

    An index is the mean square of the input's main effect, less the square that noise adds to it, over the variance that independent
    inputs would give, which is the sum of these squares and of what the main effects leave: inputs of a table that are correlated by
    chance add to its own variance or take from it.
    The noise is found from the residuals without taking them to be as large everywhere (White's estimate, HC2 of MacKinnon and
    White 1985: without bias where they are), since interactions grow towards the ends of an input.
    """
    absent = Indices(*np.full((2, len(inputs)), np.nan))
    if values.size > MOST_CASES:
        drawn = np.random.default_rng(SEED).choice(values.size, MOST_CASES, replace=False)
        inputs, values = inputs[:, drawn], values[drawn]
    cases = values.size
    values = np.ldexp(values, -int(np.frexp(np.abs(values).max(initial=0.0))[1]))  # whose squares do not overflow
    values = values - values.mean()
    if cases < CASES_PER_INPUT * len(inputs) or np.ptp(values) == 0.0:
        return absent
    count = int(np.clip(round(np.sqrt(cases / len(inputs))), 1, MOST_TERMS))  # so that misfit and noise both go to 0
    bases = [_basis(given, count) for given in inputs]
    basis = np.hstack(bases)
    gram = basis.T @ basis
    if np.linalg.eigvalsh(gram).min(initial=cases) < DEPENDENT * cases:
        return absent
    inverse = np.linalg.inv(gram)
    coefficients = inverse @ (basis.T @ values)
    leverage = np.einsum("ij,ij->i", basis @ inverse, basis) + 1.0 / cases
    misfit = values - basis @ coefficients
    residual = misfit / np.sqrt(np.maximum(1.0 - leverage, 1.0 / cases))
    covariance = inverse @ ((basis * residual[:, None] ** 2).T @ basis) @ inverse
    freedom = cases - 1 - basis.shape[1]
    ends = np.cumsum([one.shape[1] for one in bases])
    own = [slice(end - one.shape[1], end) for one, end in zip(bases, ends)]
    noise = np.array([np.trace(covariance[one, one]) for one in own])
    square = np.array([np.sum(coefficients[one] ** 2) for one in own])
    chance = np.array([_chance(covariance[one, one], freedom) for one in own])
    total = np.maximum(square - noise, 0.0).sum() + misfit @ misfit / freedom
    return Indices((square - noise) / total, (chance - noise) / total)


def ranks(values: np.ndarray) -> np.ndarray:
    """Rank of each value from 1, equal values sharing the mean of theirs."""
    return pd.Series(values).rank().to_numpy()  # scipy.stats takes 1.7 s to import


def _basis(given: np.ndarray, count: int) -> np.ndarray:
    """(cases, terms): functions of one input, of mean 0, mean square 1 and uncorrelated: Legendre polynomials of its rank and,
    for the tails, the normal score of it; as many as `count`, and as its values tell apart.
    """
    from scipy.special import ndtri  # here, since few pictures need it and it takes 0.4 s to import

    count = min(count, np.unique(given).size - 1)
    rank = (ranks(given) - 0.5) / given.size
    scores = [ndtri(rank)] if count > 2 else []
    columns = np.column_stack([np.polynomial.legendre.legvander(2.0 * rank - 1.0, count - len(scores)), *scores])
    return np.linalg.qr(columns)[0][:, 1:] * np.sqrt(given.size)


def _chance(covariance: np.ndarray, freedom: int) -> float:
    """The mean square of the fitted effect of an input without influence that 5 % of draws exceed."""
    dice = np.random.default_rng(SEED)
    variances = np.maximum(np.linalg.eigvalsh(covariance), 0.0)
    squares = dice.standard_normal((DRAWS, variances.size)) ** 2 @ variances
    return float(np.quantile(squares * freedom / dice.chisquare(freedom, DRAWS), 0.95))
