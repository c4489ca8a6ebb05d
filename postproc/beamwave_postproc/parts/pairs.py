"""Two results side by side: which cases belong together, and in what the two differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..result import NothingToDraw, swept_inputs
from .describe import brief_of, description_of, effects_of, file_of, title_of
from .head import Head
from .labels import input_name, value_text
from .scene import groups_of
from .select import spread
from .units import units_of, with_unit

MAX_PAIRS = 4
NOT_COMPARED = ("scene", "record", "spectrum", "identify", "sweep")  # groups that say nothing of the beam and its motion


class Pair(NamedTuple):
    """A case of each of two results, and what each is called where it is one of several."""

    labels: tuple[str, str]
    first: xr.Dataset
    second: xr.Dataset

    @property
    def both(self) -> tuple[xr.Dataset, xr.Dataset]:
        """The two cases."""
        return self.first, self.second


def pairs_of(first: xr.Dataset, second: xr.Dataset) -> tuple[list[Pair], str]:
    """The cases of two results that belong together, some of many, and a note on them.

    Cases of sweeps over the same values belong together; otherwise the first case of each.
    """
    if "case" in first.dims and "case" in second.dims and _same_sweep(first, second):
        shown = spread(first.sizes["case"], MAX_PAIRS)
        names = swept_inputs(first)
        labels = [", ".join(value_text(first[name][case]) for name in names) for case in shown]
        note = f"{shown.size} of {first.sizes['case']} cases" if shown.size < first.sizes["case"] else ""
        return [
            Pair((label, label), first.isel(case=case), second.isel(case=case)) for label, case in zip(labels, shown)
        ], note
    names = dict.fromkeys([*swept_inputs(first), *swept_inputs(second)])
    ones = [ds.isel(case=0) if "case" in ds.dims else ds for ds in (first, second)]
    labels = [", ".join(value_text(one[name]) for name in names if name in one and one[name].ndim == 0) for one in ones]
    swept = [name for name, ds in zip("AB", (first, second)) if "case" in ds.dims and ds.sizes["case"] > 1]
    return [Pair((labels[0], labels[1]), *ones)], f"of {' and '.join(swept)} the first case" if swept else ""


def _same_sweep(first: xr.Dataset, second: xr.Dataset) -> bool:
    """Whether two results have the same cases."""
    names = swept_inputs(first)
    return set(names) == set(swept_inputs(second)) and all(np.array_equal(first[name], second[name]) for name in names)


def head_of_both(first: xr.Dataset, second: xr.Dataset, notes: list[str], warnings: Sequence[str] = ()) -> Head:
    """Head of a picture of two results: both titles, the warning of each, what A is, what B has else, and what differs."""
    titles = [title_of(first), title_of(second)]
    title = titles[0] if titles[0] == titles[1] else f"A: {titles[0]}; B: {titles[1]}"
    mine, others = (description_of(ds).split("; ") for ds in (first, second))
    own = [part for part in others if part not in mine]
    gone = [name for name in effects_of(first) if name not in effects_of(second)]
    rest = [f"without {' and '.join(gone)}"] if gone else []
    rest += ["else as A"] if len(own) < len(others) else []
    about = f"A: {'; '.join(mine)}. B: {'; '.join([*own, *rest])}"
    name = file_of(second)
    scenes = [brief_of(first), [part for part in dict.fromkeys([name, *own, *rest]) if part]]
    scenes = [[f"{letter}: {scene[0]}", *scene[1:]] if scene else [letter] for letter, scene in zip("AB", scenes)]
    doubts = "; ".join(f"{letter}: {words}" for letter, words in zip("AB", warnings) if words)
    return Head(title, ["; ".join(filter(None, [differences(first, second), *notes]))], scenes, about, warning=doubts)


def differences(first: xr.Dataset, second: xr.Dataset) -> str:
    """In which effects and inputs two results differ, in words."""
    words = []
    effects = [effects_of(first), effects_of(second)]
    for letter, mine, others in zip("AB", effects, reversed(effects)):
        words += [f"{name} in {letter} alone" for name in mine if name not in others]
    groups = {group.name for ds in (first, second) for group in groups_of(ds)}.difference(NOT_COMPARED)
    inputs = tuple(f"{group}_" for group in groups)
    for name in [str(name) for name in first.variables if name in second and str(name).startswith(inputs)]:
        mine, other = first[name], second[name]
        if "event" in mine.dims:  # contact_force is a result
            continue
        if mine.shape != other.shape or not np.array_equal(mine.values, other.values):
            words.append(f"{input_name(name)}\u00a0=\u00a0{_values(mine)} and {_values(other)}")
    told, others = (_words(ds, groups) for ds in (first, second))
    for name in [name for name in told if told[name] != others.get(name, told[name])]:
        words.append(f"{input_name(name)}\u00a0=\u00a0{told[name]} and {others[name]}")
    return f"they differ in {', '.join(words)}" if words else "effects and inputs are the same"


def _words(ds: xr.Dataset, groups: set[str]) -> dict[str, str]:
    """The inputs of these groups that are no numbers: words, and what is chosen or not."""
    found: dict[str, list[str]] = {}
    for group in groups_of(ds):
        for name, values in group.inputs.items() if group.name in groups else ():
            words = [value for value in values if not isinstance(value, float)]
            texts = [("no", "yes")[word] if isinstance(word, bool) else word.lower() for word in words]
            found.setdefault(f"{group.name}_{name}", []).extend(texts)
    return {name: ", ".join(texts) for name, texts in found.items() if texts}


def _values(variable: xr.DataArray) -> str:
    """Value of an input with its unit, or of several the first and the last."""
    ends = dict.fromkeys(with_unit(float(variable.values.flat[i]), units_of(variable), 6) for i in (0, -1))
    return " to ".join(ends) + (" by pieces" if "piece" in variable.dims else "")


def names_of(first: xr.Dataset, second: xr.Dataset) -> tuple[str, str]:
    """What the two are called in a legend: their files, or A and B."""
    files = [file_of(ds).replace("$", r"\$") for ds in (first, second)]  # which would begin a formula
    return (f"A: {files[0]}", f"B: {files[1]}") if all(files) and files[0] != files[1] else ("A", "B")


def common_points(first: xr.Dataset, second: xr.Dataset) -> list[float]:
    """Points (ξ) that both results have; raises `NothingToDraw` where there are none."""
    found = np.intersect1d(np.round(first["point_position"].values, 9), np.round(second["point_position"].values, 9))
    if not found.size:
        raise NothingToDraw("the two results have no point in common")
    return [float(xi) for xi in found]
