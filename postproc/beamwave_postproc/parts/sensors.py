"""The sensors of a record: which are shown, and what they are called."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..result import NothingToDraw
from .labels import flag_words, in_units
from .select import left_out, spread
from .units import number_text, unit_text

MAX_SENSORS = 4
OF_QUANTITY = {"displacement": "m", "velocity": "m s-1", "acceleration": "m s-2", "strain": "1"}


def shown_sensors(ds: xr.Dataset, limit: int = MAX_SENSORS) -> tuple[list[int], str]:
    """Indices of all sensors with which lines were found, or of `limit` spread evenly, and what is left out."""
    count = ds.sizes["point"]
    used = np.arange(count)
    if "noise_deviation" in ds and (known := ds["noise_deviation"].notnull()).any():
        used = used[known.any([name for name in known.dims if name != "point"]).values]
    shown = [int(used[i]) for i in spread(used.size, limit)]
    return shown, left_out(len(shown), count, "sensors")


def sensor_name(ds: xr.Dataset, point: int) -> str:
    """What a sensor is called: its name in the file without a unit, else its number; and its place where that is known."""
    name = ""
    if "sensor_name" in ds:
        name = _text(ds["sensor_name"].values[point]).split("[")[0].split(" (")[0].strip()
    name = name or f"sensor {point + 1}"
    if "point_position" in ds:
        name += rf", $\xi$ = {number_text(float(ds['point_position'].values[point]))}"
    return name


def sensor_label(ds: xr.Dataset, point: int) -> str:
    """Label of an axis for what a sensor measures, in two lines."""
    quantity, units = _quantity(ds, point), unit_text(_units(ds, point))
    return f"{sensor_name(ds, point)}\n" + f"{quantity.capitalize()} ({units})".removesuffix(" ()").strip()


def common_label(ds: xr.Dataset, variable: str, words: str) -> str:
    """Label of an axis that all sensors share."""
    kinds = {_quantity(ds, point) for point in range(ds.sizes["point"])}
    return words + (f" of {kinds.pop()}" if len(kinds) == 1 and "" not in kinds else "") + in_units(ds[variable])


def one_record(ds: xr.Dataset) -> tuple[xr.Dataset, str]:
    """The first case with lines, for a picture that shows one; raises `NothingToDraw` where the result is of no record."""
    if str(ds.attrs.get("method", "")) != "record" and "recorded" not in ds and "noise_deviation" not in ds:
        raise NothingToDraw("the result is not that of a record")
    if "case" not in ds.dims:
        return ds, ""
    first = int(np.argmax(ds["peak_count"].values > 0)) if "peak_count" in ds else 0
    case = ds.isel(case=first)
    return case, f"case {first + 1} of {ds.sizes['case']}"


def status_words(variable: xr.DataArray, value: int) -> str:
    """What a line is, by CF flags that are bits or numbers."""
    if "flag_masks" not in variable.attrs:
        return flag_words(variable).get(value, "").replace("_", " ")
    words = str(variable.attrs.get("flag_meanings", "")).split()
    masks = np.atleast_1d(variable.attrs["flag_masks"])
    return ", ".join(word for mask, word in zip(masks, words) if value & int(mask)).replace("_", " ")


def _quantity(ds: xr.Dataset, point: int) -> str:
    """What a sensor measures; empty where its unit is not one of that, such as V."""
    quantity = "displacement"
    if "sensor_quantity" in ds:
        quantity = flag_words(ds["sensor_quantity"]).get(int(ds["sensor_quantity"].values[point]), quantity)
    return quantity if "sensor_unit" not in ds or _units(ds, point) == OF_QUANTITY[quantity] else ""


def _units(ds: xr.Dataset, point: int) -> str:
    if "sensor_unit" in ds:
        return _text(ds["sensor_unit"].values[point]).strip()
    return OF_QUANTITY[_quantity(ds, point)]


def _text(value: object) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)
