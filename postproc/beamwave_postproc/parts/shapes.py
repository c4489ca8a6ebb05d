"""Shapes of a uniform clamped beam, by their wave numbers."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr


def tip_shape(alpha: float, place: np.ndarray, strain: bool = False) -> np.ndarray:
    """The shape cosh αξ − cos αξ − σ (sinh αξ − sin αξ) of Eqs 18 and 20, or its second derivative over α².

    No small difference of large numbers is formed: all exponentials decay.
    """
    sign = -1.0 if strain else 1.0
    z, decay = alpha * place, np.exp(-alpha)
    moment_free = 2.0 * (np.sin(alpha) - np.cos(alpha) - decay) / (1.0 + (2.0 * np.sin(alpha) - decay) * decay)
    growing = 0.5 * (np.exp(z - alpha) - np.exp(-z - alpha)) - sign * np.sin(z) * decay
    return np.exp(-z) - sign * (np.cos(z) - np.sin(z)) + moment_free * growing


def known_shape(
    case: xr.Dataset, line: int, place: np.ndarray, value: np.ndarray, error: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Places along the beam and the shape of a line's wave number, as large as fits the amplitudes `value` at `place` best.

    None where the file has no wave number of it, or the ends leave more unknown than a mass at the tip.
    """
    names = ("measured_wavenumber", "beam_length", "point_position")
    if any(name not in case for name in names) or not re.search(r"ends = 'tip'", str(case.attrs.get("scene", ""))):
        return None
    alpha = float(case["measured_wavenumber"].values[line]) * float(np.sum(case["beam_length"].values))
    if not np.isfinite(alpha):
        return None
    strain = "sensor_quantity" in case and _is_strain(case["sensor_quantity"])
    along = np.linspace(0.0, 1.0, 301)
    return along, _size(tip_shape(alpha, place, strain), value, error) * tip_shape(alpha, along, strain)


def modelled_shape(
    case: xr.Dataset, line: int, place: np.ndarray, value: np.ndarray, error: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Places along the beam and the shape of the mode that a line is taken for, as large as fits the amplitudes best.

    None where the file has none.
    """
    if "modelled_shape" not in case or "point_position" not in case:
        return None
    along, shape = case["profile_position"].values, case["modelled_shape"].values[line]
    if not np.isfinite(shape).all():
        return None
    return along, _size(np.interp(place, along, shape), value, error) * shape


def _size(shape: np.ndarray, value: np.ndarray, error: np.ndarray) -> float:
    """By how much a shape at the sensors fits amplitudes best."""
    weight = 1.0 / np.maximum(np.nan_to_num(error), 1e-9 * np.abs(value).max()) ** 2
    return float(np.sum(weight * shape * value) / np.sum(weight * shape**2))


def _is_strain(quantity: xr.DataArray) -> bool:
    """Whether the sensors, which all measure one quantity, measure strain."""
    words = str(quantity.attrs.get("flag_meanings", "")).split()
    values = list(np.atleast_1d(quantity.attrs.get("flag_values", [])))
    first = int(np.atleast_1d(quantity.values)[0])
    return first in values and words[values.index(first)] == "strain"
