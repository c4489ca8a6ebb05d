"""Which scene a picture shows: its title, its effects and its inputs in words."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import xarray as xr

from ..result import RAN
from .labels import symbol_of, value_text
from .scene import Group, Value, given_in, groups_of, word_of
from .units import LONG, number_text, si_prefix, unit_text, units_of

FEW = 4  # swept values that are listed, and bodies that are told one by one
DIGITS, WHOLE = 6, 15  # of an input that is a real number, and of a whole one
MOST = 8  # values of a list, before its middle is left out
WORDS = {"plane": {"out": "out of plane", "in": "in plane"}}  # of inputs that are told by a word of their own
ELSEWHERE = ("scene", "modes", "sweep", "frequency_response")  # groups that title, notes, axes and swept inputs tell
QUIET = ("profile_points", "max_contacts", "shear_coefficient")  # told where they are given, and not by default
DEFAULTS = {"impact_position": 1.0}  # as most inputs do by 0, these say nothing by this value


def title_of(ds: xr.Dataset) -> str:
    """Title of the scene, or the name of its file without the ending; empty where a dataset has neither."""
    return str(ds.attrs.get("title", "")).strip() or Path(file_of(ds)).stem


def file_of(ds: xr.Dataset) -> str:
    """Name of the file that `ds` was opened from; empty where it was not."""
    return Path(str(ds.encoding.get("source", ""))).name


def description_of(ds: xr.Dataset) -> str:
    """All of the scene of a result in a text, groups apart by semicolons, and its file.

    Of the beam and the effects it has what was given and what is not at its default, of other groups what was given.
    Inputs that were identified are left out: what the scene gives for them is where the search began.
    """
    beam, effects, others = _told(ds)
    return "; ".join(filter(None, [*beam, *effects, *others, _ran(ds), file_of(ds)]))


def brief_of(ds: xr.Dataset) -> list[str]:
    """The file of a result, its beam, and the other groups of its scene, those first that tell one scene from another: effects."""
    beam, effects, others = _told(ds)
    return list(filter(None, [file_of(ds), _ran(ds), *beam, *effects, *others]))


def _ran(ds: xr.Dataset) -> str:
    """How many cases have run, of a sweep that is not finished."""
    return str(ds.attrs.get(RAN, ""))


def _told(ds: xr.Dataset) -> tuple[list[str], list[str], list[str]]:
    """The groups of a scene in words: the beam, its effects, and its modes with what else was given."""
    ds, hidden = _without_unknowns(ds)
    scene = groups_of(ds)
    others = dict.fromkeys(group.name for group in scene if group.name not in ("beam", *effects_of(ds), *ELSEWHERE))
    return (
        [_groups(ds, "beam", scene, hidden)],
        [_groups(ds, name, scene, hidden) for name in effects_of(ds)],
        [_modes(ds), *(_groups(ds, name, scene, hidden, only_given=True) for name in others)],
    )


def _without_unknowns(ds: xr.Dataset) -> tuple[xr.Dataset, set[str]]:
    """The same without the numbers that were identified, and their names; of several bodies or pieces the others stay.

    What is unknown of a further scene, `beam%length (scene)`, is none of this one.
    """
    hidden = set()
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
            hidden.add(f"{group}%{value}")
    return ds, hidden


def effects_of(ds: xr.Dataset) -> list[str]:
    """Names of the groups of effects and events that the scene has, in its order."""
    return [
        name
        for name in str(ds.attrs.get("effects", "")).split()
        if name not in ("beam", "modes", "response", "spectrum")
    ]


def turns_out_of_plane(ds: xr.Dataset) -> bool:
    """Whether the beam bends along the axis that it turns about."""
    return word_of(ds, "plane") == "out"


def _groups(ds: xr.Dataset, name: str, scene: list[Group], hidden: set[str], *, only_given: bool = False) -> str:
    """All groups of a name: few one by one, many together, each with its inputs that say something."""
    groups = [group for group in scene if group.name == name]
    count = ds.sizes.get(name, len(groups) or 1)
    groups += [Group(name, {})] * (count - len(groups))  # of a result without its scene
    if count > FEW:
        return _group(ds, groups[0], hidden, only_given, f"{count} bodies" if name == "body" else f"{count} × {name}")
    own = [ds.isel({name: i}).drop_vars(name, errors="ignore") if name in ds.dims else ds for i in range(count)]
    told = [_group(one, group, hidden, only_given, name) for one, group in zip(own, groups)]
    return "; ".join(filter(None, told))


def _group(ds: xr.Dataset, group: Group, hidden: set[str], only_given: bool, label: str) -> str:
    """Name of a group, its inputs that say something, its words; empty where only an effect would say so much."""
    given = {name.partition("%")[2] for name in given_in(ds) - hidden if name.partition("%")[0] == group.name}
    before = f"{group.name}_"
    variables = [str(name).removeprefix(before) for name in ds.variables if str(name).startswith(before)]
    told, words = [], []
    for name in dict.fromkeys([*group.inputs, *variables]):
        values = group.inputs.get(name, [])
        numeric = before + name in ds.variables and not (values and isinstance(values[0], str))
        variable = ds[before + name] if numeric else None
        if variable is not None and {"unknown", "event", "time"} & set(variable.dims):  # of all groups together, or found
            variable = None
        if name in WORDS and values and values[0] in WORDS[name]:
            words.append(WORDS[name][values[0]])
        elif variable is not None and (_is_told(variable, given, name) if not only_given else name in given):
            told.append(_input(variable))
        elif variable is None and name in given and values:
            told.append(_given(before + name, values))
    if not told and not words and (only_given or group.name == "beam"):
        return ""
    return " ".join(filter(None, [label, ", ".join(told), *words]))


def _is_told(variable: xr.DataArray, given: set[str], name: str) -> bool:
    """Whether an input is a number that was given, or that is not what means nothing."""
    if variable.dtype.kind not in "if" or variable.ndim > 1 or "event" in variable.dims:  # contact_force_error is a result
        return False
    known = variable.values[np.isfinite(variable.values)]
    always = name in given or variable.name in ("rotation_angular_velocity", "body_position")
    says = name not in QUIET and (known != DEFAULTS.get(str(variable.name), 0.0)).any()
    return bool(known.size and (always or says))


def _given(name: str, values: list[Value]) -> str:
    """An input that is no variable of the result, as the scene has it: words, files, a list."""
    symbol = symbol_of(name)
    if isinstance(values[0], bool):
        return symbol if values[0] else f"no {symbol}"
    texts = [_number(value) if isinstance(value, float) else Path(value).name for value in values]
    between = "\u00a0=\u00a0" if isinstance(values[0], float) else " "
    return f"{symbol}{between}{listed(texts)}"


def _number(value: float) -> str:
    return number_text(value, WHOLE if value.is_integer() and abs(value) < LONG else DIGITS)


def listed(texts: list[str], units: str = "") -> str:
    """A list and its unit; of a long list the middle is left out, and its values are counted."""
    shown = texts if len(texts) <= MOST else [*texts[: MOST - 2], "…", texts[-1]]
    count = "" if len(texts) <= MOST else f" ({len(texts)}\u00a0values)"
    return ",\u00a0".join(shown) + (f"\u00a0{units}" if units else "") + count


def _input(variable: xr.DataArray) -> str:
    """One input: its value, or what it is swept over."""
    values = np.unique(variable.values)
    digits = DIGITS if variable.dtype.kind == "f" else WHOLE
    add_up = variable.name == "beam_length" and variable.size > 1 and "piece" in variable.dims
    symbol, units = symbol_of(str(variable.name)), units_of(variable)
    if values.size == 1 and not add_up:
        return value_text(variable if variable.ndim == 0 else variable[0], digits, symbol)
    if variable.dims != ("case",):
        values = variable.values
    prefix, factor = si_prefix(values, units)
    if variable.dims == ("case",) and values.size > FEW:
        first, last = (number_text(factor * value) for value in (values[0], values[-1]))
        text = f"{symbol}\u00a0from {first} to {last}\u00a0{unit_text(prefix + units)}".rstrip("\u00a0")
        return f"{text} ({values.size}\u00a0values)"
    return f"{symbol}\u00a0=\u00a0{listed([number_text(factor * value, digits) for value in values], unit_text(prefix + units))}"


def _modes(ds: xr.Dataset) -> str:
    """How many modes were summed, or by which tolerance; of a record, in which none were, nothing."""
    if str(ds.attrs.get("method", "")) == "record":
        return ""
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
