"""The resolved scene that a result holds: its groups with their values, and which of them were given."""

from __future__ import annotations

import re
from typing import NamedTuple, Union

import xarray as xr

Value = Union[str, bool, float]
# A group begins; a name; a text in quotes, which are doubled inside; any other value; a group ends.
TOKEN = re.compile(r"&(\w+)|(\w+)\s*=|'((?:[^']|'')*)'|\"((?:[^\"]|\"\")*)\"|([^\s,/'\"]+)|/")


class Group(NamedTuple):
    """A group of the scene: its name, and the values of each of its names, both in small letters."""

    name: str
    inputs: dict[str, list[Value]]


def groups_of(ds: xr.Dataset) -> list[Group]:
    """The groups of the resolved scene, in its order; none where a dataset has no scene."""
    groups: list[Group] = []
    values: list[Value] = []
    for group, name, single, double, word in TOKEN.findall(str(ds.attrs.get("scene", ""))):
        if group:
            groups.append(Group(group.lower(), {}))
        elif name and groups:
            values = groups[-1].inputs.setdefault(name.lower(), [])
        elif word:
            values.append(_value(word))
        elif single or double:
            values.append(single.replace("''", "'") or double.replace('""', '"'))
    return groups


def _value(word: str) -> Value:
    """A number, a logical value, or else the word itself."""
    if word.lower() in (".true.", ".false."):
        return word.lower() == ".true."
    try:
        return float(word)
    except ValueError:
        return word


def given_in(ds: xr.Dataset) -> set[str]:
    """What the scene itself says, and not a default, as `group%name`."""
    return set(str(ds.attrs.get("given", "")).split())


def word_of(ds: xr.Dataset, name: str) -> str:
    """The word that a name of the scene has, in small letters; empty where the scene has none."""
    found = (values[0] for group in groups_of(ds) for key, values in group.inputs.items() if key == name and values)
    return str(next(found, "")).lower()
