"""Where an unfinished result holds its cases, found without asking the program or HDF5: by the marks in its head."""

import netCDF4
import numpy as np


def case_places(partial, variable):
    """Offset of the first case's values in the files of unfinished work, and the bytes of a case."""
    with netCDF4.Dataset(partial / "head.nc") as head:
        head.set_auto_mask(False)
        last = np.asarray(head[variable][-1])
        cases = head.dimensions["case"].size
    assert (last == last.flat[0]).all()
    marks = last.tobytes()
    data = (partial / "head.nc").read_bytes()
    assert data.count(marks) == 1
    return data.find(marks) - (cases - 1) * len(marks), len(marks)
