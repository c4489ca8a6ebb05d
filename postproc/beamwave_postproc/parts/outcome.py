"""What many cases came to, and which of their inputs explain the spread of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes

from ..result import NothingToDraw, swept_inputs
from .labels import input_label, quantity
from .main_effects import first_order_indices, ranks
from .spacing import space_axis
from .units import drawable, si_prefix, units_of

LARGEST = ("largest_displacement", "largest_stress", "largest_contact_force")  # of a sweep, whose file has no quantiles
OUTCOMES = (*LARGEST, "restitution", "final_mass_velocity")
QUANTILE = "quantile_"  # how the name of a variable begins that sums up another over the cases of a design
CRITICAL, SPEED = "critical_angular_velocity", "rotation_angular_velocity"
FEWEST = 30  # cases: of fewer chance says more than the inputs
CORRELATED = 0.3  # rank correlation of two inputs beyond which they do not vary independently …
BY_CHANCE = 4.0  # … unless it is within so many standard deviations, 1/√cases, of inputs that do
SAME = 1e-9  # of the largest: rounding


@dataclass
class Outcome:
    """One number of every case."""

    variable: xr.DataArray  # (case,), NaN where a case has none
    words: str  # what it is, with its mode or place


def outcomes_of(ds: xr.Dataset) -> list[Outcome]:
    """What a design sums up, or the largest values of a sweep, as far as it differs between cases; of modes the first, of
    points the one with the largest median. A beam that does not rotate has no critical speed worth a rank."""
    summed = [str(name)[len(QUANTILE) :] for name in ds.data_vars if str(name).startswith(QUANTILE)]
    if SPEED not in ds:
        summed = [name for name in summed if name != CRITICAL]
    found = []
    for name in [one for one in summed if one in ds] or [one for one in OUTCOMES if one in ds]:
        one = _outcome(ds, drawable(ds[name]))
        values = one.variable.values
        finite = values[np.isfinite(values)]
        if finite.size >= 2 and np.ptp(finite) > 0.0:
            found.append(one)
    return found


def _outcome(ds: xr.Dataset, variable: xr.DataArray) -> Outcome:
    words = quantity(variable)
    if variable.name == "angular_frequency":
        variable = as_frequency(variable)
        words = "Frequency"
    for dim in [str(dim) for dim in variable.dims if dim != "case"]:
        place = 0 if dim != "point" else int(np.nanargmax(_medians(variable)))
        variable = variable.isel({dim: place})
        if dim == "point" and "point_position" in ds:
            words += rf" at $\xi$ = {float(ds['point_position'][place]):g}"
        else:
            words += f", {dim} {place + 1}"
    return Outcome(variable, words[:1].upper() + words[1:])


def as_frequency(variable: xr.DataArray) -> xr.DataArray:
    """Angular frequencies in Hz."""
    return (variable / (2.0 * np.pi)).assign_attrs(units="Hz", long_name="Frequency").rename("frequency_hz")


def input_axis(axes: Axes, which: Literal["x", "y"], variable: xr.DataArray) -> np.ndarray:
    """Label one axis of an input, logarithmic where its values are spaced so or span decades; returns the values in its unit."""
    prefix, factor = si_prefix(variable.values, units_of(variable))
    values = factor * variable.values.astype(float)
    axes.set(**{f"{which}label": input_label(variable, prefix)})
    space_axis(axes, which, values)
    return values


def _medians(variable: xr.DataArray) -> np.ndarray:
    values = variable.transpose("case", ...).values
    held = np.isfinite(values).any(axis=0)
    return np.array([np.nanmedian(values[:, i]) if held[i] else -1.0 for i in range(values.shape[1])])


def rankings(ds: xr.Dataset) -> pd.DataFrame:
    """Return which inputs explain the spread of what the cases came to: a row for each outcome and input.

    `rank_correlation` is Spearman's, −1 … 1. `first_order_index` is Sobol's, the part of the variance that the input explains
    by itself, by the main effects of all inputs together (`first_order_indices`); it needs inputs that vary independently and
    four cases for each, and is NaN otherwise. `by_chance` is what an input without influence exceeds once in twenty times.
    Raises `NothingToDraw` of fewer than 30 cases, or where nothing varies.
    """
    names = varied_inputs(ds)
    outcomes = outcomes_of(ds) if "case" in ds.dims else []
    if not outcomes or not names:
        raise NothingToDraw("nothing that differs from case to case")
    tables = [ranking_of(ds, names, one) for one in outcomes if np.isfinite(one.variable.values).sum() >= FEWEST]
    if not tables:
        raise NothingToDraw(f"fewer than {FEWEST} cases that differ")
    return pd.concat(tables, ignore_index=True)


def varies(values: np.ndarray) -> bool:
    """Whether numbers of the cases differ by more than rounding; those that are not known do not count."""
    known = values[np.isfinite(values)]
    return known.size > 1 and float(np.ptp(known)) > SAME * float(np.abs(known).max())


def varied_inputs(ds: xr.Dataset) -> list[str]:
    """The inputs that differ between cases."""
    return [name for name in swept_inputs(ds) if np.ptp(ds[name].values) > 0.0]


def ranking_of(ds: xr.Dataset, names: list[str], outcome: Outcome) -> pd.DataFrame:
    """The rows of one outcome in `rankings`."""
    held = np.isfinite(outcome.variable.values)
    values = outcome.variable.values[held]
    inputs = np.array([ds[name].values[held].astype(float) for name in names])
    table = pd.DataFrame({"outcome": outcome.words, "input": names, "cases": values.size})
    table["rank_correlation"] = [_correlation(given, values) for given in inputs]
    alone = dependence(inputs) <= max(CORRELATED, BY_CHANCE / np.sqrt(values.size))
    indices = first_order_indices(inputs, values) if alone else None
    table["first_order_index"] = indices.first_order if indices else np.nan
    table["by_chance"] = indices.by_chance if indices else np.nan
    return table


def strength(table: pd.DataFrame) -> pd.Series:
    """By what inputs are ordered: their first-order index, or their rank correlation where there is none."""
    return table["first_order_index"].fillna(table["rank_correlation"].abs())


def dependence(inputs: np.ndarray) -> float:
    """The largest rank correlation between two of the inputs (inputs, cases), without its sign."""
    pairs = [_correlation(inputs[i], inputs[j]) for i in range(len(inputs)) for j in range(i)]
    return float(max(map(abs, pairs), default=0.0))


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Spearman's; 0 where one of both is the same in all cases."""
    both = [ranks(one), ranks(other)]
    return float(np.corrcoef(both)[0, 1]) if all(np.ptp(rank) > 0.0 for rank in both) else 0.0
