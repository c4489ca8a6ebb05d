"""One reader for each kind of file, told by its first bytes: path and wishes in, channels out."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import scipy.io
import scipy.io.wavfile

from .channels import Channel, NotARecord, Wanted, channels_of, even_times
from .universal import universal_channels

ACCEPTED = "UFF 58 or 58b, MATLAB, NumPy or WAV"


def read_channels(path: Path, wanted: Wanted | None = None) -> list[Channel]:
    """The histories in a file; raises `NotARecord` where it holds none, and `OSError` where it cannot be read."""
    wanted = wanted or Wanted()
    with path.open("rb") as file:
        start = file.read(600)
    if start.startswith(b"\x93NUMPY"):
        return numpy_channels(path, wanted)
    if start.startswith((b"RIFF", b"RIFX", b"RF64")):
        return sound_channels(path, wanted)
    if start[512:520] == b"\x89HDF\r\n\x1a\n" or (start.startswith(b"MATLAB 7.3")):
        return channels_of(_hdf5_arrays(path), wanted, path.name)
    if start.startswith(b"MATLAB") or path.suffix.lower() == ".mat":
        return channels_of(_matlab_arrays(path), wanted, path.name)
    if any(line.strip() == b"-1" for line in start.splitlines()[:3]):
        return universal_channels(path, needed("pyuff", "UFF files"))
    raise NotARecord(f"neither {ACCEPTED}; text and NetCDF are read by &record as they are")


def needed(module: str, files: str) -> ModuleType:
    """A module that only some files need; raises `NotARecord` where it is not installed."""
    try:
        return import_module(module)
    except ImportError as missing:
        raise NotARecord(
            f"reading {files} takes the Python package {module}: pip install 'beamwave_postproc[records]'"
        ) from missing


def numpy_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """An array of histories, named after the file, or with names of its own columns."""
    try:
        array = np.load(path, allow_pickle=False)
    except (ValueError, EOFError) as failure:
        raise NotARecord(f"no array of numbers ({failure})") from failure
    arrays = {path.stem: array}
    if array.dtype.names:
        arrays = {name: array[name] for name in array.dtype.names}
    return channels_of(arrays, wanted, path.name)


def sound_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """The channels of a sound file, as parts of its full scale."""
    try:
        rate, data = scipy.io.wavfile.read(path)
    except OSError:
        raise
    except Exception as failure:  # whatever scipy stumbles over in a damaged file
        raise NotARecord(f"no sound file that can be read ({failure})") from failure
    if data.dtype == np.uint8:
        data = (data.astype(float) - 128.0) / 128.0
    elif data.dtype.kind == "i":
        data = data / -float(np.iinfo(data.dtype).min)
    columns = data.reshape(len(data), -1)
    times = even_times(len(columns), 1.0 / (wanted.sample_rate or rate))
    return [
        Channel(f"channel_{number}", values, times, unit="1", description="part of full scale")
        for number, values in enumerate(columns.T, 1)
    ]


def _matlab_arrays(path: Path) -> dict[str, np.ndarray]:
    """Arrays of a .mat file up to version 7.2, those in structures and cells as `_flat` names them."""
    try:
        found = scipy.io.loadmat(path, simplify_cells=True)
    except OSError:
        raise
    except Exception as failure:  # whatever scipy stumbles over in a damaged file
        raise NotARecord(f"no MATLAB file that can be read ({failure})") from failure
    return _flat({name: value for name, value in found.items() if not name.startswith("__")})


class Rows(dict[str, Any]):
    """Rows of cells, or structures of an array, by number."""


def _members(cells: Any) -> Mapping[str, Any]:
    """Cells by number; of several rows with several cells each, and of structures, rows by number."""
    if isinstance(cells, np.ndarray) and cells.ndim > 1 and min(cells.shape) > 1:
        return Rows({str(row): _members(list(members)) for row, members in enumerate(cells, 1)})
    flat = cells.ravel() if isinstance(cells, np.ndarray) else cells
    members = {str(number): cell for number, cell in enumerate(flat, 1)}
    return Rows(members) if any(isinstance(cell, Mapping) for cell in members.values()) else members


def _flat(values: Mapping[str, Any], before: str = "") -> dict[str, np.ndarray]:
    """Arrays and numbers of nested structures and cells, by their paths.

    A field of a structure is `structure.field`; cell 2 of row 3 is `cells{3}.2`, of a single row `cells.2`.
    """
    arrays = {}
    for name, value in values.items():
        if isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
            value = _members(value)
        if isinstance(value, Rows):
            for number, row in value.items():
                arrays |= _flat({f"{name}{{{number}}}": row}, before)
        elif isinstance(value, Mapping):
            arrays |= _flat(value, f"{before}{name}.")
        elif isinstance(value, (np.ndarray, int, float, np.generic)):
            arrays[before + name] = np.asarray(value)
    return arrays


def _hdf5_arrays(path: Path) -> dict[str, np.ndarray]:
    """Arrays of a .mat file of version 7.3, which is HDF5, as `_flat` names them."""
    h5py = needed("h5py", "MATLAB 7.3 files")

    def value(item: Any) -> Any:
        """A structure as its fields, cells as an array of what they hold, numbers, or nothing."""
        if isinstance(item, h5py.Group):
            fields = {name: value(field) for name, field in item.items()}
            cells = [field.attrs.get("MATLAB_class", b"") == b"cell" for field in item.values()]
            several = [isinstance(field, np.ndarray) and field.dtype == object for field in fields.values()]
            if not all(several) or any(cells) or len({field.size for field in fields.values()}) != 1:
                return fields
            rows = zip(*(field.ravel() for field in fields.values()))
            return [dict(zip(fields, row)) for row in rows]
        if h5py.check_ref_dtype(item.dtype):
            held = item[()].T  # MATLAB stores columns one after another
            cells = np.empty(held.shape, dtype=object)
            for place, reference in np.ndenumerate(held):
                cells[place] = value(file[reference])
            return cells
        odd = item.attrs.get("MATLAB_class", b"") == b"char" or "MATLAB_empty" in item.attrs
        return item[()] if item.dtype.kind in "fiub" and not odd else None

    with h5py.File(path, "r") as file:
        return _flat({name: value(item) for name, item in file.items() if not name.startswith("#")})
