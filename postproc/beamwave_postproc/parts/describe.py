"""Which scene a picture shows: its title, its effects and its inputs in words."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import xarray as xr

from .labels import symbol_of, value_text
from .units import number_text, unit_text, units_of

FEW = 4  # swept values that are listed, and bodies that are told one by one
WORDS = {"plane": {"out": "out of plane", "in": "in plane"}}  # of inputs that are words, those that are told
NOT_TOLD = ("profile_points", "max_contacts", "shear_coefficient")
DEFAULTS = {"impact_position": 1.0}  # as most inputs do by 0, these say nothing by this value


def title_of(ds: xr.Dataset) -> str:
    """Title of the scene, or the name of its file without the ending; empty where a dataset has neither."""
    return str(ds.attrs.get("title", "")).strip() or Path(file_of(ds)).stem


def file_of(ds: xr.Dataset) -> str:
    """Name of the file that `ds` was opened from; empty where it was not."""
    return Path(str(ds.encoding.get("source", ""))).name


def description_of(ds: xr.Dataset) -> str:
    """Beam, effects and inputs of a result in one line, groups apart by semicolons, and its file.

    Inputs that were identified are not told: what the scene gives for them is where a search began.
    """
    ds = _without_unknowns(ds)
    beam = _group(ds, "beam")
    effects = [_bodies(ds) if name == "body" else _group(ds, name) for name in effects_of(ds)]
    groups = ["" if beam == "beam" else beam, *effects, _modes(ds)]
    return "; ".join(filter(None, [*groups, file_of(ds)]))


def _without_unknowns(ds: xr.Dataset) -> xr.Dataset:
    """The same without the numbers that were identified; of several bodies or pieces those of the others stay.

    What is unknown of a further scene, `beam%length (scene)`, is none of this one.
    """
    for parameter in ds["identified_parameter"].values if "identified_parameter" in ds else []:
        name = parameter.decode() if isinstance(parameter, bytes) else str(parameter)
        found = re.fullmatch(r"(\w+)(?:\((\d+)\))?%(\w+)(?:\((\d+)\))?", name.strip())
        if not found:
            continue
        group, number, value, piece = found.groups()
        variable = f"{group}_{value}"
        if (number or piece) and variable in ds:
            ds = ds.assign({variable: ds[variable].where(np.arange(ds[variable].size) != int(number or piece) - 1)})
        else:
            ds = ds.drop_vars(variable, errors="ignore")
    return ds


def effects_of(ds: xr.Dataset) -> list[str]:
    """Names of the groups of effects and events that the scene has, in its order."""
    return [
        name
        for name in str(ds.attrs.get("effects", "")).split()
        if name not in ("beam", "modes", "response", "spectrum")
    ]


def turns_out_of_plane(ds: xr.Dataset) -> bool:
    """Whether the beam bends along the axis that it turns about."""
    return _word(ds, "plane") == "out"


def _group(ds: xr.Dataset, group: str) -> str:
    """Name of a group, its inputs that say something, its words."""
    names = [str(name) for name in ds.variables if str(name).startswith(f"{group}_")]
    told = [_input(ds[name]) for name in names if _says_something(ds, name, group)]
    words = [
        words[_word(ds, name)] for name, words in WORDS.items() if group == "rotation" and _word(ds, name) in words
    ]
    return " ".join(filter(None, [group, ", ".join(told), *words]))


def _bodies(ds: xr.Dataset) -> str:
    """What is attached to the beam: of few bodies each with what it has, of many how many there are."""
    count = ds.sizes.get("body", 0)
    if not 0 < count <= FEW:
        return f"{count} bodies" if count else _group(ds, "body")
    inputs = ds[[name for name in ds.data_vars if str(name).startswith("body_")]].reset_coords(drop=True)
    return "; ".join(_group(inputs.isel(body=body), "body") for body in range(count))


def _says_something(ds: xr.Dataset, name: str, group: str) -> bool:
    """Whether an input is a number that is not left at what means nothing."""
    variable = ds[name]
    if name.removeprefix(f"{group}_") in NOT_TOLD or variable.dtype.kind not in "if" or variable.ndim > 1:
        return False
    values = variable.values
    known = values[np.isfinite(values)]
    always = name in ("rotation_angular_velocity", "body_position")
    return bool(known.size and (always or (known != DEFAULTS.get(name, 0.0)).any()))


def _input(variable: xr.DataArray) -> str:
    """One input: its value, or what it is swept over."""
    values = np.unique(variable.values)
    add_up = variable.name == "beam_length" and variable.size > 1 and "piece" in variable.dims
    if values.size == 1 and not add_up:
        return value_text(variable if variable.ndim == 0 else variable[0])
    symbol, units = symbol_of(str(variable.name)), unit_text(units_of(variable))
    if variable.dims != ("case",):
        values = variable.values
    elif values.size > FEW:
        first, last = number_text(values[0]), number_text(values[-1])
        text = f"{symbol}\u00a0from {first} to {last}\u00a0{units}".rstrip("\u00a0")
        return f"{text} ({values.size}\u00a0values)"
    listed = ",\u00a0".join(map(number_text, values[: 2 * FEW]))
    return f"{symbol}\u00a0=\u00a0{listed}\u00a0{units}".rstrip("\u00a0")


def _modes(ds: xr.Dataset) -> str:
    """How many modes were summed, or by which tolerance."""
    if "modes_tolerance" in ds:
        return f"{_input(ds['modes_tolerance'])}" + (
            f" ({_count(ds['mode_count'])} modes)" if "mode_count" in ds else ""
        )
    before = "modes_before" in ds and _count(ds["modes_before"])
    after = "modes_after" in ds and _count(ds["modes_after"])
    if before and after and "capture" in effects_of(ds):
        return f"{before} modes before, {after} after"
    return f"{before or after} modes" if before or after else ""


def _count(variable: xr.DataArray) -> str:
    """A whole number, or the range of a sweep."""
    values = np.unique(variable.values)
    return f"{values[0]:.0f}" if values.size == 1 else f"{values[0]:.0f} to {values[-1]:.0f}"


def _word(ds: xr.Dataset, name: str) -> str:
    """Value of a word of the scene, in small letters; empty where the scene has none."""
    found = re.search(rf"\b{name}\s*=\s*['\"](\w+)", str(ds.attrs.get("scene", "")), re.IGNORECASE)
    return found.group(1).lower() if found else ""
