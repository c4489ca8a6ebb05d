"""From result files to PNG, GIF, CSV and HTML files: each function handles one and returns the exit status."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Callable

import xarray as xr
from matplotlib.figure import Figure

from .compare import compare
from .film.frames import save_film
from .film.motion import motion
from .kinds import KINDS, pictures
from .page.html import page_of, page_of_two
from .parts.pairs import differences
from .result import NothingToDraw, open_result
from .terminal import reason
from .tool import EXIT_DONE, EXIT_FILE, FILM_SECONDS, PICTURE_SECONDS, Tool
from .writing import MARK

DPI = 200


def draw_file(tool: Tool, source: Path, directory: Path) -> int:
    """Draw every picture that a result holds the numbers for; what hinders one does not hinder the others."""

    def write() -> int:
        failed: dict[str, list[str]] = {}
        drawn = 0
        with open_result(source) as ds:
            for kind, draw in KINDS.items():
                try:
                    _save_picture(tool, directory / f"{source.stem}_{kind}.png", partial(draw, ds))
                    drawn += 1
                except NothingToDraw:
                    continue
                except Exception as failure:  # whatever a library stumbles over in strange numbers
                    failed.setdefault(reason(failure), []).append(kind)
        for why, kinds in failed.items():
            tool.complain(f"{source}: {', '.join(kinds)}: {why}")
        if not drawn and not failed:
            raise NothingToDraw("nothing in it to draw")
        return EXIT_FILE if failed else EXIT_DONE

    return tool.each([source], directory, write)


def draw_one(tool: Tool, source: Path, path: Path, draw: Callable[[xr.Dataset], Figure]) -> int:
    """Draw one picture of a result."""
    return write_from(tool, source, path.parent, lambda ds: _save_picture(tool, path, partial(draw, ds)))


def page_file(tool: Tool, source: Path, path: Path) -> int:
    """Write the page of a result."""
    return write_from(tool, source, path.parent, lambda ds: _save_text(tool, path, lambda: page_of(ds, pictures(ds))))


def film_file(tool: Tool, source: Path, path: Path) -> int:
    """Film a result as GIF, with remarks on standard error on what the film cannot show."""

    def write(ds: xr.Dataset) -> None:
        tool.allow(FILM_SECONDS)
        shown = motion(ds)
        for remark in shown.remarks:
            tool.complain(f"{source}: film: {remark}")
        save_film(shown, path, overwrite=tool.overwrite)
        tool.say(str(path))

    return write_from(tool, source, path.parent, write)


def compare_files(tool: Tool, first: Path, second: Path, directory: Path, *, page: bool) -> int:
    """Draw two results laid over each other into `directory`, as pictures or as one page."""
    stem = f"{first.stem}_and_{second.stem}"

    def write() -> None:
        with open_result(first) as a, open_result(second) as b:
            tool.allow(PICTURE_SECONDS * len(KINDS))
            drawn = compare(a, b)
            if page:
                text = partial(page_of_two, a, b, drawn, differences(a, b))
                _save_text(tool, directory / f"{stem}.html", text)
                return
            for kind, fig in drawn.items():
                _save_figure(tool, directory / f"{stem}_{kind}.png", fig)

    return tool.each([first, second], directory, write)


def write_from(tool: Tool, source: Path, directory: Path, write: Callable[[xr.Dataset], None]) -> int:
    """Open a result and `write` what is made of it into `directory`."""

    def work() -> None:
        with open_result(source) as ds:
            write(ds)

    return tool.each([source], directory, work)


def _save_picture(tool: Tool, path: Path, draw: Callable[[], Figure]) -> None:
    tool.allow(PICTURE_SECONDS)
    _save_figure(tool, path, draw())


def _save_figure(tool: Tool, path: Path, fig: Figure) -> None:
    tool.save(path, lambda draft: fig.savefig(draft, dpi=DPI, metadata={"Software": MARK, "Description": fig.get_label()}), MARK)


def _save_text(tool: Tool, path: Path, write: Callable[[], str]) -> None:
    tool.allow(PICTURE_SECONDS * len(KINDS))
    text = write()
    tool.save(path, lambda draft: draft.write_text(text, encoding="utf-8", errors="backslashreplace"), MARK)
