"""Which points, cases and modes of a result a picture shows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Optional, Union

import numpy as np
import xarray as xr

from ..result import NothingToDraw, swept_inputs
from .labels import value_text

Chosen = Optional[Union[float, Iterable[float]]]
SAME_POINT = 1e-9  # positions are typed as decimals; two that differ by less are one point
# What has these dimensions in a file, so that a selection of one (`ds.sel(mode=1)`) can be drawn as well.
HOLDERS = {
    "point": ("displacement", "velocity", "bending_moment", "amplitude"),
    "mode": (
        *("alpha", "wavenumber", "angular_frequency", "growth_rate", "modal_mass", "modal_velocity"),
        *("phase_velocity", "group_velocity", "mode_shape"),
    ),
}
COORDINATES = {"point": "point_position", "mode": "mode"}


def chosen(ds: xr.Dataset, *, points: Chosen = None, cases: Chosen = None, modes: Chosen = None) -> xr.Dataset:
    """`ds` with the points at these ξ, the cases and modes of these numbers (from 1), in this order; None takes all.

    A dimension that the caller's own selection has taken away is put back. Raises `NothingToDraw`, saying what there
    is, where the result lacks one of them.
    """
    for dim in HOLDERS:
        ds = _restored(ds, dim)
    ds = _taken(ds, "point", "point_position", points, "point at")
    ds = _taken(ds, "case", "case", cases, "case")
    if modes is not None and "mode_before" in ds.dims:
        there = np.intersect1d(np.atleast_1d(_numbers(modes)), ds["mode_before"].values)
        ds = ds.sel(mode_before=there)
    return _taken(ds, "mode", "mode", modes, "mode")


def spread(count: int, limit: int) -> np.ndarray:
    """Indices of all of `count`, or of `limit` of them spread evenly, first and last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, limit)).round().astype(int))


def left_out(shown: int, count: int, words: str) -> str:
    """How many of what there is are shown; empty where all are."""
    return f"{shown} of {count} {words}" if shown < count else ""


def _taken(ds: xr.Dataset, dim: str, coordinate: str, wanted: Chosen, words: str) -> xr.Dataset:
    """Those along `dim` whose coordinate is one of `wanted`."""
    if wanted is None:
        return ds
    if coordinate not in ds or ds[coordinate].dims != (dim,):
        raise NothingToDraw(f"the result has no {words} {_listed(_numbers(wanted))}: it has no dimension {dim}")
    there = ds[coordinate].values
    indices = []
    for value in _numbers(wanted):
        near = np.flatnonzero(np.abs(there - value) < SAME_POINT)
        if not near.size:
            raise NothingToDraw(f"the result has no {words} {value:g}; it has {_listed(there)}")
        indices.append(int(near[0]))
    if not indices:
        raise NothingToDraw(f"no {dim} is chosen")
    return ds.isel({dim: indices})


def _numbers(wanted: Chosen) -> np.ndarray:
    return np.atleast_1d(np.asarray(wanted if np.isscalar(wanted) else list(wanted), dtype=float))


def _listed(values: np.ndarray) -> str:
    """Some numbers in words, at most eight."""
    return ", ".join(f"{value:g}" for value in values[:8]) + (", …" if len(values) > 8 else "")


def _restored(ds: xr.Dataset, dim: str) -> xr.Dataset:
    """Put back a dimension of which one was selected: its coordinate is then a scalar."""
    coordinate = COORDINATES[dim]
    if dim in ds.dims or coordinate not in ds or ds[coordinate].ndim:
        return ds
    names = [name for holder in HOLDERS[dim] for name in (holder, f"{holder}_error", f"{holder}_bound") if name in ds]
    value, attributes = ds[coordinate].values, ds[coordinate].attrs
    ds = ds.drop_vars(coordinate)
    axis = {name: int("case" in ds[name].dims) for name in names}
    ds = ds.assign({name: ds[name].expand_dims(dim, axis=axis[name]) for name in names})
    return ds.assign_coords({coordinate: (dim, [value], attributes)})


def one_case(ds: xr.Dataset) -> tuple[xr.Dataset, str]:
    """The first case of a sweep, for a picture that shows one, and a note on which that is."""
    if "case" not in ds.dims:
        return ds, ""
    case = ds.isel(case=0)
    inputs = ", ".join(value_text(case[name]) for name in swept_inputs(ds))
    count = f" of {ds.sizes['case']}" if ds.sizes["case"] > 1 else ""
    return case, f"case {int(case['case'])}{count}: {inputs}"
