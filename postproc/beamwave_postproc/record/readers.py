"""One reader for each kind of file, told by its first bytes: path and wishes in, channels out."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Callable

import numpy as np
import scipy.io
import scipy.io.wavfile

from ..terminal import reason
from .channels import Channel, NotARecord, Wanted, channels_of, even_times, needed, refuse_inconsistent
from .tables import text_channels
from .universal import universal_channels

ACCEPTED = "UFF 58 or 58b, MATLAB, NumPy, WAV, or text of a logger"


def read_channels(path: Path, wanted: Wanted | None = None) -> list[Channel]:
    """The histories in a file; raises `NotARecord` where it holds none, and `OSError` where it cannot be read."""
    wanted = wanted or Wanted()
    if path.exists() and not path.is_file():
        raise NotARecord("is no file")
    with path.open("rb") as file:
        start = file.read(600)
    kind, read = _reader(start, path.suffix.lower())
    try:
        channels = read(path, wanted)
        for channel in channels:
            refuse_inconsistent(channel)
        return channels
    except (OSError, MemoryError, NotARecord):
        raise
    except Exception as failure:  # whatever a library stumbles over in a damaged file
        raise NotARecord(f"no {kind} that can be read ({reason(failure)})") from failure


Reader = Callable[[Path, Wanted], "list[Channel]"]


def _reader(start: bytes, suffix: str) -> tuple[str, Reader]:
    """What a file is by its first bytes, and who reads that."""
    if start.startswith(b"\x93NUMPY") or (start.startswith(b"PK") and suffix == ".npz"):
        return "array of numbers", numpy_channels
    if start.startswith((b"RIFF", b"RIFX", b"RF64")):
        return "sound file", sound_channels
    if start[512:520] == b"\x89HDF\r\n\x1a\n" or (start.startswith(b"MATLAB 7.3")):
        return "MATLAB file", hdf5_channels
    if start.startswith(b"MATLAB") or suffix == ".mat":
        return "MATLAB file", matlab_channels
    if any(line.strip() == b"-1" for line in start.splitlines()[:3]):
        return "universal file", universal_channels
    if start.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" not in start:
        return "table of text", text_channels
    raise NotARecord(f"neither {ACCEPTED}; NetCDF is read by &record as it is")


def numpy_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """Arrays of histories: one named after the file, those of an archive, or columns with names of their own."""
    held = np.load(path, allow_pickle=False)
    arrays = dict(held) if isinstance(held, np.lib.npyio.NpzFile) else {path.stem: held}
    for name, array in list(arrays.items()):
        if array.dtype.names:
            arrays |= {column: array[column] for column in array.dtype.names}
    return channels_of(arrays, wanted, path.name)


def sound_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """The channels of a sound file, as parts of its full scale; one that is not as long as it says is refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", scipy.io.wavfile.WavFileWarning)
        warnings.filterwarnings("ignore", "Chunk")  # that is not sound
        rate, data = scipy.io.wavfile.read(path)
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


def matlab_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """Arrays of a .mat file up to version 7.2, those in structures and cells as `_flat` names them."""
    found = scipy.io.loadmat(path, simplify_cells=True)
    return channels_of(
        _flat({name: value for name, value in found.items() if not name.startswith("__")}), wanted, path.name
    )


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


def hdf5_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """Arrays of a .mat file of version 7.3, which is HDF5, as `_flat` names them; other files are not followed."""
    h5py = needed("h5py", "MATLAB 7.3 files")

    def members(group: Any) -> dict[str, Any]:
        """What a group holds itself."""
        for name in group:
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise NotARecord(f"{name} is a link to elsewhere, which is not followed")
        return {name: value(group[name]) for name in group if not name.startswith("#")}

    def value(item: Any) -> Any:
        """A structure as its fields, cells as an array of what they hold, numbers, or nothing."""
        if isinstance(item, h5py.Group):
            fields = members(item)
            cells = [item[name].attrs.get("MATLAB_class", b"") == b"cell" for name in fields]
            several = [isinstance(field, np.ndarray) and field.dtype == object for field in fields.values()]
            if not all(several) or any(cells) or len({field.size for field in fields.values()}) != 1:
                return fields
            rows = zip(*(field.ravel() for field in fields.values()))
            return [dict(zip(fields, row)) for row in rows]
        if item.external or item.is_virtual:
            raise NotARecord(f"{item.name} lies in another file, which is not read")
        if h5py.check_ref_dtype(item.dtype):
            held = item[()].T  # MATLAB stores columns one after another
            cells = np.empty(held.shape, dtype=object)
            for place, reference in np.ndenumerate(held):
                cells[place] = value(file[reference])
            return cells
        odd = item.attrs.get("MATLAB_class", b"") == b"char" or "MATLAB_empty" in item.attrs
        return item[()] if item.dtype.kind in "fiub" and not odd else None

    with h5py.File(path, "r") as file:
        return channels_of(_flat(members(file)), wanted, path.name)
