"""The cases of a result as curves: which are drawn, what each is called, how each looks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from .labels import value_text
from .result import swept_inputs
from .style import MAX_CURVES, curve_style


@dataclass(frozen=True)
class Curve:
    """One case: its number among the curves, the dataset without `case`, legend text and look."""

    index: int
    data: xr.Dataset
    label: str
    style: dict[str, Any]


def curves_of(ds: xr.Dataset, limit: int = MAX_CURVES) -> list[Curve]:
    """All cases of `ds`, or `limit` of them spread evenly; without a sweep the one there is."""
    if "case" not in ds.dims:
        return [Curve(0, ds, "", curve_style(0))]
    shown = _shown(ds, limit)
    names = _differing(ds, shown)
    cases = [shown.isel(case=case) for case in range(shown.sizes["case"])]
    return [
        Curve(i, case, ", ".join(value_text(case[name]) for name in names), curve_style(i))
        for i, case in enumerate(cases)
    ]


def _shown(ds: xr.Dataset, limit: int = MAX_CURVES) -> xr.Dataset:
    """Those cases of a sweep that are drawn."""
    count = ds.sizes["case"]
    return ds.isel(case=np.unique(np.linspace(0, count - 1, min(count, limit)).round().astype(int)))


def _differing(ds: xr.Dataset, shown: xr.Dataset) -> list[str]:
    """Inputs swept in `ds` that tell the cases in `shown` apart; all of them where none does."""
    names = swept_inputs(ds)
    return [name for name in names if np.unique(shown[name].values).size > 1] or names


def heading(ds: xr.Dataset, *inputs: str) -> str:
    """Legend title: the values of `inputs`, and of what is swept, that all cases shown share; how many are shown."""
    shared = [value_text(ds[name]) for name in inputs if name in ds and ds[name].ndim == 0]
    count = ds.sizes.get("case", 1)
    if "case" in ds.dims:
        shown = _shown(ds)
        told = _differing(ds, shown)
        shared += [value_text(shown[name][0]) for name in swept_inputs(ds) if name not in told]
    if count > MAX_CURVES:
        shared.append(f"{MAX_CURVES} of {count} cases")
    return ", ".join(shared)
