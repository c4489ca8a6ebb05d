"""A result as the file holds it: raw numbers, fill included, and what makes two of them the same."""

from typing import NamedTuple

import netCDF4
import numpy as np

FILL = netCDF4.default_fillvals["f8"]
FROM_RUN_TO_RUN = {"stage_seconds", "created", "history"}  # all that may differ between two runs of a scene


class Variable(NamedTuple):
    """One variable."""

    dimensions: tuple
    values: np.ndarray
    attributes: dict


class Result(NamedTuple):
    """A whole file."""

    attributes: dict
    sizes: dict
    variables: dict

    def __getitem__(self, name):
        return self.variables[name].values


def attributes_of(thing):
    return {name: thing.getncattr(name) for name in thing.ncattrs()}


def read(path):
    """Read everything."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        file.set_auto_scale(False)
        variables = {
            name: Variable(item.dimensions, np.array(item[...]), attributes_of(item))
            for name, item in file.variables.items()
        }
        sizes = {name: len(item) for name, item in file.dimensions.items()}
        return Result(attributes_of(file), sizes, variables)


def bits(variable):
    """All there is to a variable, as something to compare."""
    attributes = {name: np.asarray(value).tolist() for name, value in variable.attributes.items()}
    return variable.dimensions, variable.values.dtype, variable.values.shape, variable.values.tobytes(), attributes


def differences(one, other):
    """Names of attributes and variables that are not the same to the bit, those apart that need not be."""
    names = (set(one.attributes) | set(other.attributes)) - FROM_RUN_TO_RUN
    differing = {name for name in names if one.attributes.get(name) != other.attributes.get(name)}
    names = (set(one.variables) | set(other.variables)) - FROM_RUN_TO_RUN
    for name in names:
        there = name in one.variables and name in other.variables
        if not there or bits(one.variables[name]) != bits(other.variables[name]):
            differing.add(name)
    return sorted(differing)


def is_fill(values):
    """Where nothing is."""
    return np.asarray(values) == FILL
