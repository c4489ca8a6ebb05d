"""Histories of universal files, data sets 58 and 58b."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .channels import Channel, NotARecord, Wanted, even_times, needed

TIME = 17  # what the abscissa is, in the numbers of the format
QUANTITIES = {8: "displacement", 11: "velocity", 12: "acceleration", 3: "strain"}
DIRECTIONS = {1: "+x", -1: "-x", 2: "+y", -2: "-y", 3: "+z", -3: "-z"}


def universal_channels(path: Path, wanted: Wanted) -> list[Channel]:
    """Every data set that is a history; spectra and geometry are passed over. The file itself says the times."""
    file = needed("pyuff", "UFF files").UFF(str(path))
    places = [place for place, kind in enumerate(file.get_set_types()) if int(kind) == 58]
    sets = [file.read_sets(place) for place in places]
    histories = [
        one for one in sets if int(one.get("abscissa_spec_data_type", 0)) == TIME and np.isrealobj(one["data"])
    ]
    if not histories:
        raise NotARecord(f"{len(sets)} data sets 58, and none of them is a history in time")
    return [_channel(one, number) for number, one in enumerate(histories, 1)]


def _channel(one: dict[str, Any], number: int) -> Channel:
    """One data set; what stands behind its last sample fills up a line."""
    values = np.asarray(one["data"], dtype=float)
    count = int(one["num_pts"])
    if not 0 < count <= values.size:
        raise NotARecord(f"history {number} holds {values.size} samples, and its header says {count}")
    values = values[:count]
    if int(one.get("abscissa_spacing", 1)) == 1:
        times = even_times(values.size, whole_interval(float(one["abscissa_inc"])), float(one.get("abscissa_min", 0.0)))
    else:
        times = np.asarray(one["x"], dtype=float)[:count]
    words = [str(one.get(key, "")).strip() for key in ("id1", "id2")]
    return Channel(
        name=_name(one, number),
        values=values,
        times=times,
        unit=_known(one.get("ordinate_axis_units_lab", "")),
        quantity=QUANTITIES.get(int(one.get("ordinate_spec_data_type", 0)), ""),
        description=", ".join(word for word in words if _known(word)),
    )


def whole_interval(written: float) -> float:
    """The interval of which a header has six digits: of all that are written so, that of the roundest sampling rate.

    Taken as it stands, 4.88281e-04 s would move every frequency of a record at 2048 Hz by 5e-7 of it.
    """
    for digits in range(1, 7) if 0.0 < written < np.inf else ():
        for interval in (1.0 / float(f"{1.0 / written:.{digits - 1}e}"), float(f"{written:.{digits - 1}e}")):
            if f"{interval:.5e}" == f"{written:.5e}":
                return interval
    return written


def _name(one: dict[str, Any], number: int) -> str:
    """The response's name, or node and direction, or the number of the history."""
    node, direction = int(one.get("rsp_node", 0)), int(one.get("rsp_dir", 0))
    place = f"{node}{DIRECTIONS.get(direction, '')}" if node else ""
    name = _known(one.get("rsp_ent_name", ""))
    return "_".join(part for part in (name, place) if part) or f"history_{number}"


def _known(text: object) -> str:
    """A text, unless it says that there is none."""
    word = str(text).strip()
    return "" if word.upper() in {"NONE", "NULL", "UNKNOWN", "UNKNOWN UNIT"} else word
