"""Unfinished work as it lies in its directory, which a run may remove at any moment, and its finished cases."""

import os

import netCDF4
import numpy as np
from workplace import wait_until

NOT_DONE = -1


def files_in(directory, ending):
    """Paths of the files with this ending, in order of their names; none where the directory is gone."""
    try:
        return [directory / name for name in sorted(os.listdir(directory)) if name.endswith(ending)]
    except FileNotFoundError:
        return []


def drafts_in(directory):
    """The drafts of unfinished work; one that is being laid out has no head yet."""
    return [path for path in files_in(directory, ".nc") if path.name.startswith("draft") and begins_with(path, b"CDF")]


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


def wait_for_cases(here):
    """Until a first case of the scene `a` is saved."""
    wait_until(lambda: cases_in(here.directory / "output/a.partial"))
