"""The finished cases that unfinished work holds, read by the NetCDF library."""

import netCDF4
import numpy as np

NOT_DONE = -1


def drafts_in(directory):
    """The drafts of unfinished work; one that is being laid out has no head yet."""
    return [path for path in sorted(directory.glob("draft*.nc")) if begins_with(path, b"CDF")]


def begins_with(path, letters):
    try:
        with path.open("rb") as file:
            return file.read(len(letters)) == letters
    except FileNotFoundError:
        return False


def cases_in(directory):
    """Numbers of all cases that are done in some draft of the directory."""
    found = set()
    for path in drafts_in(directory):
        try:
            file = netCDF4.Dataset(path)
        except OSError:  # its head is being written, or the run has just given it its name
            continue
        with file:
            file.set_auto_mask(False)
            statuses = np.atleast_1d(file["case_status"][...])
        found |= set((1 + np.flatnonzero(statuses != NOT_DONE)).tolist())
    return found
