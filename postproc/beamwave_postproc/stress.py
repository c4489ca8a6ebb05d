"""Strain and stress of the outermost fibres, from the bending moment of a result."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .parts.section import Section, sections_at
from .parts.select import chosen
from .result import NothingToDraw, require


def strain(ds: xr.Dataset, *, reach: float | None = None, error: bool = False) -> xr.DataArray:
    """Bending strain (1) of the outermost fibre at each point and time, positive with the moment: M c/(EI).

    `reach` is c, the distance (m) from the neutral axis to that fibre, and has to be given where the result knows the
    section by area and second moment alone, without `extreme_fibre`. Where two pieces meet the larger strain of both is taken. With `error` the
    estimated error at each point instead. Raises `NothingToDraw` without bending moments.
    """
    return _of_moment(ds, "strain", reach, error)


def stress(ds: xr.Dataset, *, reach: float | None = None, error: bool = False) -> xr.DataArray:
    """Bending stress (Pa) of the outermost fibre at each point and time, M c/I; all else as `strain`."""
    return _of_moment(ds, "stress", reach, error)


def factors(case: xr.Dataset, quantity: str, reach: float | None = None) -> np.ndarray:
    """What the bending moment (N m) at each point of one case is multiplied by, for its 'strain' or 'stress'."""
    return np.array(
        [
            max(_factor(section, quantity, reach) for section in sections_at(case, xi))
            for xi in case["point_position"].values
        ]
    )


def _of_moment(ds: xr.Dataset, quantity: str, reach: float | None, error: bool) -> xr.DataArray:
    name = "bending_moment_error" if error else "bending_moment"
    ds = chosen(ds)
    require(ds, name, "point_position")
    if "case" in ds.dims:
        factor = xr.DataArray(
            [factors(ds.isel(case=i), quantity, reach) for i in range(ds.sizes["case"])], dims=("case", "point")
        )
    else:
        factor = xr.DataArray(factors(ds, quantity, reach), dims="point")
    found = (ds[name] * factor).transpose(*ds[name].dims).rename(f"{quantity}_error" if error else quantity)
    words = f"bending {quantity} of the outermost fibre"
    found.attrs = {
        "units": {"strain": "1", "stress": "Pa"}[quantity],
        "long_name": f"error of the {words}" if error else words,
    }
    return found


def _factor(section: Section, quantity: str, reach: float | None) -> float:
    """M c/(EI) or M c/I for a moment of 1 N m."""
    distance = section.reach if reach is None else reach
    if distance is None:
        raise NothingToDraw(
            "the section does not tell the outermost fibre's distance: give it as reach, or as extreme_fibre in the scene"
        )
    if section.is_lumped and quantity == "stress":
        raise NothingToDraw("the beam is known by mass per length and bending stiffness: its modulus and stress are not")
    by_stress = distance / section.second_moment
    return by_stress / section.youngs_modulus if quantity == "strain" else by_stress
