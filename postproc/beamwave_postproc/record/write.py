"""Channels into a NetCDF file: one variable each along `time`, as `&record` reads it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path

import netCDF4
import numpy as np

from ..result import netcdf_path
from ..writing import put
from .channels import Channel

MOST = 2**32 - 4  # bytes of a variable in the classic format


def grouped(channels: Iterable[Channel]) -> list[list[Channel]]:
    """Channels by their record and their times: one file holds one axis of time."""
    groups: list[list[Channel]] = []
    for channel in channels:
        for group in groups:
            same = group[0].times is channel.times or np.array_equal(group[0].times, channel.times)
            if same and group[0].record == channel.record:
                group.append(channel)
                break
        else:
            groups.append([channel])
    return groups


def write_record(channels: Sequence[Channel], path: Path, source: str, *, overwrite: bool = False) -> None:
    """Write channels of one axis of time; `source` is what the file says of where they come from.

    Raises `FileExistsError` where something has the name of the file, unless with `overwrite`.
    """
    netcdf_path(path)
    put(path, partial(_write, channels, source), overwrite=overwrite)


def _write(channels: Sequence[Channel], source: str, path: Path) -> None:
    """Write a file that every NetCDF library reads."""
    large = any(8 * channel.values.size >= MOST for channel in channels)
    with netCDF4.Dataset(path.absolute(), "w", format=f"NETCDF3_64BIT_{'DATA' if large else 'OFFSET'}") as file:
        file.Conventions = "CF-1.11"
        file.source = source
        file.createDimension("time", channels[0].times.size)
        time = file.createVariable("time", "f8", ("time",))
        time.units, time.long_name = "s", "time"
        time[:] = channels[0].times
        names: set[str] = {"time", "t"}
        for channel in channels:
            kind = "f4" if channel.values.dtype == np.float32 else "f8"
            variable = file.createVariable(_free_name(channel.name, names), kind, ("time",), fill_value=False)
            if channel.unit:
                variable.units = channel.unit
            variable.long_name = channel.description or channel.name
            if channel.quantity:
                variable.quantity = channel.quantity
            if channel.position is not None:
                variable.position = channel.position
            variable[:] = channel.values


def _free_name(name: str, taken: set[str]) -> str:
    """A name that NetCDF takes and no variable has."""
    plain = re.sub(r"[/\x00-\x1f\x7f]", "_", name).strip() or "history"
    if not (plain[0].isalnum() or plain[0] == "_"):
        plain = f"_{plain}"
    free, number = plain, 1
    while free.lower() in taken:
        number += 1
        free = f"{plain}_{number}"
    taken.add(free.lower())
    return free
