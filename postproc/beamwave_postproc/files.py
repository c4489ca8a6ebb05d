"""From result files to PNG, GIF, CSV and HTML files: each function handles one and returns the exit status."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Callable

import matplotlib as mpl
import xarray as xr
from matplotlib.figure import Figure

from .compare import compare
from .film.frames import save_film
from .film.motion import motion
from .kinds import KINDS, pictures
from .page.html import page_of, page_of_two
from .parts.pairs import differences
from .parts.sheet import of_size, write_png
from .result import NothingToDraw, open_result
from .terminal import Refusal, reason
from .tool import EXIT_DONE, EXIT_FILE, EXIT_USAGE, FILM_SECONDS, PICTURE_SECONDS, Tool
from .writing import MARK

DPI = 200
FORMATS = ("png", "pdf", "svg")
# Letters of a PDF stay letters, and an SVG of the same numbers is the same file.
OUTPUT = {"pdf.fonttype": 42, "svg.hashsalt": MARK}


@dataclass(frozen=True)
class Wish:
    """Which pictures are drawn (all where none is named), in which format, and of which size (inches)."""

    only: tuple[str, ...] = ()
    format: str = "png"
    size: tuple[float, float] | None = None

    @property
    def kinds(self) -> dict[str, Callable[[xr.Dataset], Figure]]:
        """The pictures by their names."""
        return {kind: draw for kind, draw in KINDS.items() if not self.only or kind in self.only}


def draw_file(tool: Tool, source: Path, directory: Path, wish: Wish = Wish()) -> int:
    """Draw the pictures that are wished for of those that a result holds the numbers for, each whatever hinders others.

    Of those that were named the missing ones are told, with what the result has.
    """

    def write() -> int:
        with open_result(source):
            pass  # what is no result is refused once
        kinds = list(wish.kinds.items())
        parts = tool.share(len(kinds), partial(some, kinds))
        failed = {kind: why for part in parts for kind, why in part["failed"]}
        reasons: dict[str, list[str]] = {}
        for kind in filter(failed.__contains__, wish.kinds):
            reasons.setdefault(failed[kind], []).append(kind)
        for why, names in reasons.items():
            tool.complain(f"{source}: {', '.join(names)}: {why}")
        if not failed and not any(part["drawn"] for part in parts):
            raise NothingToDraw("nothing in it to draw")
        return EXIT_FILE if failed else EXIT_DONE

    def some(kinds: list[tuple[str, Callable[[xr.Dataset], Figure]]], numbers: Iterator[int]) -> dict[str, Any]:
        """Draw those of these numbers; how many were drawn, and which failed for what reason."""
        failed: list[tuple[str, str]] = []
        drawn = 0
        with open_result(source) as ds:
            for kind, draw in map(kinds.__getitem__, numbers):
                try:
                    _save_picture(tool, directory / f"{source.stem}_{kind}.{wish.format}", partial(draw, ds), wish.size)
                    drawn += 1
                except NothingToDraw as lack:
                    failed += [(kind, f"{reason(lack)}; it can give {_listed(tool, ds)}")] if wish.only else []
                except Exception as failure:  # whatever a library stumbles over in strange numbers
                    failed.append((kind, reason(failure)))
        return {"drawn": drawn, "failed": failed}

    return tool.each([source], directory, write)


def name_pictures(tool: Tool, source: Path, unknown: list[str]) -> int:
    """Say that pictures of these names do not exist, and which a result can give; returns the status of a wrong word."""

    def work() -> int:
        with open_result(source) as ds:
            tool.complain(f"--only {', '.join(unknown)}: no such picture; {source} can give {_listed(tool, ds)}")
        return EXIT_USAGE

    return tool.each([source], source.parent, work)


def _listed(tool: Tool, ds: xr.Dataset) -> str:
    """The names of the pictures that a result can give."""
    tool.allow(PICTURE_SECONDS * len(KINDS))
    return ", ".join(pictures(ds))


def draw_one(tool: Tool, source: Path, path: Path, draw: Callable[[xr.Dataset], Figure]) -> int:
    """Draw one picture of a result."""
    return write_from(tool, source, path.parent, lambda ds: _save_picture(tool, path, partial(draw, ds)))


def page_file(tool: Tool, source: Path, path: Path, wish: Wish = Wish()) -> int:
    """Write the page of a result, with the pictures that are wished for."""

    def text(ds: xr.Dataset) -> str:
        with of_size(wish.size):
            return page_of(ds, pictures(ds, wish.kinds))

    return write_from(tool, source, path.parent, lambda ds: _save_text(tool, path, partial(text, ds)))


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


def compare_files(tool: Tool, first: Path, second: Path, directory: Path, *, page: bool, suffix: str = "png") -> int:
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
                _save_figure(tool, directory / f"{stem}_{kind}.{suffix}", fig)

    return tool.each([first, second], directory, write)


def write_from(tool: Tool, source: Path, directory: Path, write: Callable[[xr.Dataset], None]) -> int:
    """Open a result and `write` what is made of it into `directory`."""

    def work() -> None:
        with open_result(source) as ds:
            write(ds)

    return tool.each([source], directory, work)


def _save_picture(
    tool: Tool, path: Path, draw: Callable[[], Figure], size: tuple[float, float] | None = None
) -> None:
    tool.allow(PICTURE_SECONDS)
    try:
        with of_size(size):
            fig = draw()
        _save_figure(tool, path, fig)
    except MemoryError as failure:
        if size is None:
            raise
        raise Refusal("a picture of this --size takes more memory than is allowed; accepted: a smaller one") from failure


def _save_figure(tool: Tool, path: Path, fig: Figure) -> None:
    about = fig.get_label()
    told = {
        ".png": {"Software": MARK, "Description": about},
        ".pdf": {"Creator": MARK, "Subject": about, "CreationDate": None},
        ".svg": {"Creator": MARK, "Description": about, "Date": None},
    }[path.suffix]

    def write(draft: Path) -> None:
        if path.suffix == ".png":
            write_png(fig, draft, DPI, told)
        else:
            fig.savefig(draft, dpi=DPI, metadata=told)

    with mpl.rc_context(OUTPUT):
        tool.save(path, write, MARK)


def _save_text(tool: Tool, path: Path, write: Callable[[], str]) -> None:
    tool.allow(PICTURE_SECONDS * len(KINDS))
    text = write()
    tool.save(path, lambda draft: draft.write_text(text, encoding="utf-8", errors="backslashreplace"), MARK)
