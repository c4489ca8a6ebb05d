"""From result files to PNG, GIF, CSV and HTML files, one failure at a time."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Callable

import xarray as xr
from matplotlib.figure import Figure

from .compare import compare
from .film.frames import save_film
from .film.motion import motion
from .kinds import pictures
from .page.html import page_of, page_of_two
from .parts.pairs import differences
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
    print(path)


def draw_file(source: Path, draw: Callable[[xr.Dataset], dict[Path, Figure]]) -> bool:
    """Draw one result, naming what was written on standard output and failures on standard error."""
    return read_file(source, lambda ds: _save_all(draw(ds)))


def page_file(source: Path, path: Path) -> bool:
    """Write the page of one result."""
    return read_file(source, lambda ds: save(path, partial(_write, text=page_of(ds, pictures(ds)))))


def compare_files(first: Path, second: Path, directory: Path, *, page: bool) -> bool:
    """Draw two results laid over each other into `directory`, as pictures or as one page."""
    stem = f"{first.stem}_and_{second.stem}"

    def write(a: xr.Dataset, b: xr.Dataset) -> None:
        drawn = compare(a, b)
        if page:
            save(directory / f"{stem}.html", partial(_write, text=page_of_two(a, b, drawn, differences(a, b))))
        else:
            _save_all({directory / f"{stem}_{kind}.png": fig for kind, fig in drawn.items()})

    return read_file(first, lambda a: _require_read(second, lambda b: write(a, b)))


def film_file(source: Path, path: Path) -> bool:
    """Film one result as GIF, with remarks on standard error on what the film cannot show."""

    def write(ds: xr.Dataset) -> None:
        shown = motion(ds)
        for remark in shown.remarks:
            print(f"{source}: film: {remark}", file=sys.stderr)
        save(path, partial(save_film, shown))

    return read_file(source, write)


def read_file(source: Path, write: Callable[[xr.Dataset], None]) -> bool:
    """Open `source` and `write` what is made of it; whether that went well, else why not on standard error."""
    try:
        _require_read(source, write)
    except NotAResult as problem:
        print(problem, file=sys.stderr)
    except (NothingToDraw, OSError, RuntimeError) as problem:  # netCDF4 says RuntimeError of damaged data
        print(f"{source}: {problem}", file=sys.stderr)
    else:
        return True
    return False


def _require_read(source: Path, write: Callable[[xr.Dataset], None]) -> None:
    with open_result(source) as ds:
        write(ds)


def _save_all(drawn: dict[Path, Figure]) -> None:
    for path, fig in drawn.items():
        save(path, partial(fig.savefig, dpi=DPI))


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
