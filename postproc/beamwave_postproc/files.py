"""From result files to PNG, GIF and CSV files, one failure at a time."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Callable

import xarray as xr
from matplotlib.figure import Figure

from .film import save_film
from .motion import motion
from .result import NotAResult, NothingToDraw, open_result

EXIT_DONE, EXIT_USAGE, EXIT_FILE = 0, 2, 3
DPI = 200


def save(path: Path, write: Callable[[Path], object]) -> None:
    """Have `write` write a file; nothing half-written is left behind when that fails."""
    try:
        write(path)
    except OSError:
        path.unlink(missing_ok=True)
        raise


def draw_file(source: Path, draw: Callable[[xr.Dataset], dict[Path, Figure]]) -> bool:
    """Draw one result, naming what was written on standard output and failures on standard error."""

    def write(ds: xr.Dataset) -> None:
        for path, fig in draw(ds).items():
            save(path, partial(fig.savefig, dpi=DPI))
            print(path)

    return read_file(source, write)


def film_file(source: Path, path: Path) -> bool:
    """Film one result as GIF, with remarks on standard error on what the film cannot show."""

    def write(ds: xr.Dataset) -> None:
        shown = motion(ds)
        for remark in shown.remarks:
            print(f"{source}: film: {remark}", file=sys.stderr)
        save_film(shown, path)
        print(path)

    return read_file(source, write)


def read_file(source: Path, write: Callable[[xr.Dataset], None]) -> bool:
    """Open `source` and `write` what is made of it; whether that went well."""
    try:
        with open_result(source) as ds:
            write(ds)
    except NotAResult as problem:
        print(problem, file=sys.stderr)
    except (NothingToDraw, OSError, RuntimeError) as problem:  # netCDF4 says RuntimeError of damaged data
        print(f"{source}: {problem}", file=sys.stderr)
    else:
        return True
    return False
