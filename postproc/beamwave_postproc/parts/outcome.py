"""What many cases came to, and which of their inputs explain the spread of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from ..result import NothingToDraw, swept_inputs
from .labels import quantity

LARGEST = ("largest_displacement", "largest_stress", "largest_contact_force")  # of a sweep, whose file has no quantiles
QUANTILE = "quantile_"  # how the name of a variable begins that sums up another over the cases of a design
FEWEST = 30  # cases: of fewer chance says more than the inputs
FULLEST, MOST_PARTS = 16, 32  # cases in each part of an input's values, and how many parts there are at most
FEWEST_ALIKE = 4  # cases of one value that are a part by themselves
CORRELATED = 0.3  # rank correlation of two inputs beyond which they do not vary independently
DRAWS = 200  # of an input without influence
SEED = 20261127


@dataclass
class Outcome:
    """One number of every case."""

    variable: xr.DataArray  # (case,), NaN where a case has none
    words: str  # what it is, with its mode or place


def outcomes_of(ds: xr.Dataset) -> list[Outcome]:
    """What a design sums up, or the largest values of a sweep, as far as it differs between cases; of modes the first, of
    points the one with the largest median."""
    summed = [str(name)[len(QUANTILE) :] for name in ds.data_vars if str(name).startswith(QUANTILE)]
    found = []
    for name in [one for one in summed if one in ds] or [one for one in LARGEST if one in ds]:
        one = _outcome(ds, ds[name])
        values = one.variable.values
        finite = values[np.isfinite(values)]
        if finite.size >= 2 and np.ptp(finite) > 0.0:
            found.append(one)
    return found


def _outcome(ds: xr.Dataset, variable: xr.DataArray) -> Outcome:
    words = quantity(variable)
    if variable.name == "angular_frequency":
        variable = (variable / (2.0 * np.pi)).assign_attrs(units="Hz", long_name="Frequency").rename("frequency_hz")
        words = "Frequency"
    for dim in [str(dim) for dim in variable.dims if dim != "case"]:
        place = 0 if dim != "point" else int(np.nanargmax(_medians(variable)))
        variable = variable.isel({dim: place})
        if dim == "point" and "point_position" in ds:
            words += rf" at $\xi$ = {float(ds['point_position'][place]):g}"
        else:
            words += f", {dim} {place + 1}"
    return Outcome(variable, words[:1].upper() + words[1:])


def _medians(variable: xr.DataArray) -> np.ndarray:
    values = variable.transpose("case", ...).values
    held = np.isfinite(values).any(axis=0)
    return np.array([np.nanmedian(values[:, i]) if held[i] else -1.0 for i in range(values.shape[1])])


def rankings(ds: xr.Dataset) -> pd.DataFrame:
    """Return which inputs explain the spread of what the cases came to: a row for each outcome and input.

    `rank_correlation` is Spearman's, −1 … 1. `first_order_index` is Sobol's, the part of the variance that the input explains
    by itself: 1 − the variance within parts of its values over the variance of all, both without bias (Kelley's ε²); it needs
    inputs that vary independently, and is NaN where two are correlated. `by_chance` is what an input without influence
    exceeds once in twenty times. Raises `NothingToDraw` of fewer than 30 cases, or where nothing varies.
    """
    names = swept_inputs(ds)
    outcomes = outcomes_of(ds) if "case" in ds.dims else []
    if not outcomes or not names:
        raise NothingToDraw("nothing that differs from case to case")
    inputs = {name: ds[name].values.astype(float) for name in names if np.ptp(ds[name].values) > 0.0}
    dice = np.random.default_rng(SEED)
    rows = []
    for outcome in outcomes:
        values = outcome.variable.values
        held = np.isfinite(values)
        if held.sum() < FEWEST:
            continue
        alone = dependence(np.array([given[held] for given in inputs.values()])) <= CORRELATED
        for name, given in inputs.items():
            row = {"outcome": outcome.words, "input": name, "cases": int(held.sum())}
            row["rank_correlation"] = _correlation(given[held], values[held])
            row["first_order_index"] = first_order_index(given[held], values[held]) if alone else np.nan
            row["by_chance"] = _by_chance(given[held], values[held], dice) if alone else np.nan
            rows.append(row)
    if not rows:
        raise NothingToDraw(f"fewer than {FEWEST} cases that differ")
    return pd.DataFrame(rows)


def dependence(inputs: np.ndarray) -> float:
    """The largest rank correlation between two of the inputs (inputs, cases), without its sign."""
    pairs = [_correlation(inputs[i], inputs[j]) for i in range(len(inputs)) for j in range(i)]
    return float(max(map(abs, pairs), default=0.0))


def first_order_index(given: np.ndarray, values: np.ndarray) -> float:
    """The part of the variance of `values` that `given` explains by itself, estimated without bias; NaN of too few."""
    return _index(_parts(given), values)


def _by_chance(given: np.ndarray, values: np.ndarray, dice: np.random.Generator) -> float:
    """The index that an input with these values and without influence exceeds in 5 % of draws."""
    parts = _parts(given)
    return float(np.quantile([_index(parts, dice.permutation(values)) for _ in range(DRAWS)], 0.95))


def _parts(given: np.ndarray) -> np.ndarray:
    """In which part of its values each lies: each value is one if few differ, else as many cases are in each part."""
    values, which = np.unique(given, return_inverse=True)
    if values.size <= min(MOST_PARTS, given.size // FEWEST_ALIKE):
        return which
    parts = int(np.clip(given.size // FULLEST, 2, MOST_PARTS))
    from scipy.stats import rankdata  # here, since few pictures need it and it takes 1 s to import

    return ((rankdata(given, method="ordinal") - 1) * parts // given.size).astype(int)


def _index(parts: np.ndarray, values: np.ndarray) -> float:
    counts = np.bincount(parts)
    freedom = values.size - counts.size
    total = values.var(ddof=1)
    if freedom < 1 or total == 0.0:
        return float("nan")
    sums = np.bincount(parts, weights=values - values.mean())
    within = values.var() * values.size - np.sum(sums**2 / counts)
    return float(1.0 - within / freedom / total)


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    from scipy.stats import rankdata

    return float(np.corrcoef(rankdata(one), rankdata(other))[0, 1])
