"""The waves that were measured, as tables: `python -m beamwave_postproc.peaks FILE.nc …`.

Writes `<stem>_peaks.csv` beside each result: a line for each spectral peak, in SI units.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import xarray as xr

from .draw.measured import QUANTITIES
from .files import write_from
from .result import require
from .terminal import Words
from .tool import Tool, command

NAMES = ("angular_frequency", "decay_rate", *QUANTITIES[1:])
MEASURED = [f"measured_{name}{part}" for name in NAMES for part in ("", "_error", "_bound")] + ["peak_status"]


def peaks(ds: xr.Dataset) -> pd.DataFrame:
    """Return one row for each spectral peak, by `peak` and in a sweep by `case`; swept inputs are columns.

    Of a record also decay, bounds and status where the file has them; waves where it has those.
    """
    require(ds, "measured_angular_frequency", "measured_angular_frequency_error")
    return ds[[name for name in MEASURED if name in ds]].to_dataframe().dropna(subset=["measured_angular_frequency"])


def main(argv: Sequence[str] | None = None) -> int:
    """Write the tables; 0, or 3 if any of them could not be written."""
    words = Words(prog="python -m beamwave_postproc.peaks", description=__doc__.splitlines()[0])
    words.add_argument("files", metavar="FILE.nc", nargs="+", type=Path, help="a result of beamwave with a spectrum")
    words.add_argument("--overwrite", action="store_true", help="replace files that are there and are not its own")
    return command(words, lambda given, tool: max(_write(tool, file) for file in given.files), argv)


def _write(tool: Tool, source: Path) -> int:
    """Write the table of one file beside it; the exit status."""

    def write(ds: xr.Dataset) -> None:
        path = source.with_name(f"{source.stem}_peaks.csv")
        tool.save(path, peaks(ds).to_csv, mark=MEASURED[0])

    return write_from(tool, source, source.parent, write)


if __name__ == "__main__":
    sys.exit(main())
