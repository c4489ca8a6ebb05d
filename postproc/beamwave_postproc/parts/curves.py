"""The cases of a result as curves: which are drawn, side by side in which panels, what each is called, how it looks."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..result import NothingToDraw, require, swept_inputs
from ..style import MAX_CURVES, curve_style
from .labels import how_it_ended, input_name, value_text
from .scene import groups_of
from .select import spread

MAX_PANELS = 4
CURVES_OF_MANY_PANELS = 5
SAME = 1e-12  # of the largest number: rounding
DIGITS = (4, 6, 9, 12, 17)  # of inputs in words: as many as tell the cases apart


@dataclass(frozen=True)
class Curve:
    """One case: its number among the curves, the dataset without `case`, legend text and look."""

    index: int
    data: xr.Dataset
    label: str
    style: dict[str, Any]


@dataclass(frozen=True)
class Panel:
    """Curves that belong on one pair of axes, and what their cases share where other panels differ."""

    title: str
    curves: list[Curve]


@dataclass(frozen=True)
class Panels:
    """What is drawn of a result, and what has to be said of the rest."""

    panels: list[Panel]
    notes: list[str] = field(default_factory=list)

    @property
    def curves(self) -> list[Curve]:
        """All curves, panel by panel."""
        return [curve for panel in self.panels for curve in panel.curves]


def panels_of(ds: xr.Dataset, name: str, *, panels: int = MAX_PANELS) -> Panels:
    """The cases of `ds` as curves of variable `name` in at most so many panels.

    One panel without a sweep, and of a sweep of one input. In a sweep of several inputs the curves of one panel differ
    in the input that varies fastest and the panels in the next one; further inputs stay at their first value. Cases
    that are not the product of their inputs share a panel. Raises `NothingToDraw` where no case holds a number.
    """
    require(ds, name)
    if "case" not in ds.dims:
        drawn = Panels([Panel("", [Curve(0, ds, "", curve_style(0))])])
    else:
        names = [swept for swept in swept_inputs(ds) if np.unique(ds[swept]).size > 1]
        grid = _grid(ds, names)
        drawn = _one_panel(ds, names) if grid is None else _product(ds, names, grid, panels)
    return _with_numbers(drawn, name)


def where_it_varies(ds: xr.Dataset, *names: str) -> tuple[xr.Dataset, str]:
    """The cases of a sweep in which one of the variables `names` differs, and which inputs leave all as they are, in words.

    Along each of those inputs the first value is kept; a single case that is left has no dimension `case`.
    """
    idle = [swept for swept in swept_inputs(ds) if all(_is_idle(ds, name, swept) for name in names)]
    if not idle:
        return ds, ""
    kept = ds
    for swept in idle:
        kept = kept.isel(case=np.flatnonzero(kept[swept].values == kept[swept].values[0]))
    symbols = " and ".join(input_name(swept) for swept in idle)
    return (kept.isel(case=0) if kept.sizes["case"] == 1 else kept), f"the same for all {symbols}"


def _is_idle(ds: xr.Dataset, name: str, swept: str) -> bool:
    """Whether cases that differ in the input `swept` alone, of which there are some, have one and the same `name`."""
    others = [other for other in swept_inputs(ds) if other != swept]
    keys = list(zip(*(ds[other].values for other in others))) if others else [()] * ds.sizes["case"]
    first: dict[tuple, int] = {}
    pairs = [(case, first.setdefault(key, case)) for case, key in enumerate(keys)]
    if not len(first) * np.unique(ds[swept]).size == len(keys) > len(first):
        return False
    values = ds[name].values
    rounding = SAME * np.nanmax(np.abs(values), initial=0.0)
    return all(np.allclose(values[i], values[j], rtol=0.0, atol=rounding, equal_nan=True) for i, j in pairs)


def is_grid(ds: xr.Dataset, names: list[str]) -> bool:
    """Whether the cases are the product of several inputs."""
    return _grid(ds, names) is not None


def _grid(ds: xr.Dataset, names: list[str]) -> np.ndarray | None:
    """Index of each case by the values of its inputs, where there are several and the cases are their product."""
    if len(names) < 2:
        return None
    places = [np.unique(ds[name], return_inverse=True) for name in names]
    shape = [values.size for values, _ in places]
    flat = np.ravel_multi_index([place for _, place in places], shape)
    if flat.size != np.prod(shape) or np.unique(flat).size != flat.size:
        return None
    return np.argsort(flat).reshape(shape)


def _one_panel(ds: xr.Dataset, names: list[str]) -> Panels:
    """All cases, or some spread evenly, on one pair of axes."""
    count = ds.sizes["case"]
    shown = spread(count, MAX_CURVES)
    curves = _curves(ds, shown, names or swept_inputs(ds))
    return Panels([Panel("", curves)], [f"{shown.size} of {count} cases"] if shown.size < count else [])


def _product(ds: xr.Dataset, names: list[str], grid: np.ndarray, panels: int) -> Panels:
    """Panels along the last but one input, curves along the last; one panel stays at the first value of the former."""
    held = names[: -1 if panels == 1 else -2]
    plane = np.atleast_2d(grid[(0,) * len(held)])
    rows = spread(plane.shape[0], panels)
    columns = spread(plane.shape[1], CURVES_OF_MANY_PANELS)
    titles = _labels(ds, plane[rows, 0], names[-2:-1]) if panels > 1 else [""]
    drawn = [Panel(title, _curves(ds, plane[row, columns], names[-1:])) for title, row in zip(titles, rows)]
    count = rows.size * columns.size
    words = [f"{count} of {ds.sizes['case']} cases"] if count < ds.sizes["case"] else []
    words += [f"all with {value_text(ds[name][plane[0, 0]])}" for name in held]
    return Panels(drawn, [", ".join(words)] if words else [])


def _curves(ds: xr.Dataset, cases: np.ndarray, names: list[str]) -> list[Curve]:
    labels = _labels(ds, cases, names)
    return [Curve(i, ds.isel(case=case), labels[i], curve_style(i)) for i, case in enumerate(cases)]


def _labels(ds: xr.Dataset, cases: np.ndarray, names: list[str]) -> list[str]:
    """Values of inputs in words, a text for each case, with enough digits to tell apart what differs."""
    files = [Path(str(name)).name for group in groups_of(ds) if group.name == "record" for name in group.inputs.get("file", [])]
    if names == ["record_file"] and files:
        return [files[int(number) - 1] for number in ds["record_file"].values[cases]]
    values = ds[names].isel(case=cases) if names else None
    if values is None:
        return [f"case {int(ds['case'][case])}" if "case" in ds.coords else f"case {case + 1}" for case in cases]
    different = len({tuple(float(values[name][i]) for name in names) for i in range(len(cases))})
    texts: list[str] = []
    for digits in DIGITS:
        texts = [
            ", ".join(value_text(values[name][i], digits, among=values[name].values) for name in names)
            for i in range(len(cases))
        ]
        if len(set(texts)) == different:
            break
    return texts


def _with_numbers(drawn: Panels, name: str) -> Panels:
    """Without the cases that hold nothing but fill, which a note names."""
    empty = [curve for curve in drawn.curves if not np.isfinite(curve.data[name].values).any()]
    if len(empty) == len(drawn.curves):
        raise NothingToDraw(f"{name} holds nothing but fill")
    gone = {id(curve) for curve in empty}
    panels = [Panel(panel.title, [c for c in panel.curves if id(c) not in gone]) for panel in drawn.panels]
    words = [f"no numbers: {curve.label}{how_it_ended(curve.data)}" for curve in empty if curve.label]
    return Panels([panel for panel in panels if panel.curves], [*drawn.notes, *words])
