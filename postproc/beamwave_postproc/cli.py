"""The command `beamwave-plot`: draws what result files hold."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from .files import FORMATS, Wish, compare_files, draw_file, film_file, name_pictures, page_file
from .kinds import KINDS
from .terminal import Words
from .tool import EXIT_DONE, EXIT_FILE, Tool, WrongWords, command, refuse_repeated
from .writing import make_directory

MM = 1.0 / 25.4  # inches
LEAST, MOST = 1.5, 60.0  # inches, of a side of a picture


def parser() -> argparse.ArgumentParser:
    """Return the words of the command line."""
    words = Words(prog="beamwave-plot", description="Draws what beamwave results hold.")
    words.add_argument(
        "files", metavar="PATH", nargs="+", type=Path, help="a result of beamwave; a directory stands for its *.nc"
    )
    words.add_argument("--output", metavar="DIR", type=Path, help="where the pictures go (default: beside each file)")
    words.add_argument("--overwrite", action="store_true", help="replace files that are there and are not its own")
    words.add_argument(
        "--page", action="store_true", help="one HTML page with report, notes and pictures instead, <stem>.html"
    )
    words.add_argument("--compare", action="store_true", help="lay two results over each other")
    words.add_argument(
        "--only", metavar="NAME", action="append", default=[], help="this picture alone: repeatable, or several with commas"
    )
    words.add_argument("--format", choices=FORMATS, default="png", help="of the pictures (default: png)")
    words.add_argument(
        "--size", metavar="WxH", type=size_of, help="width and height of each, in mm, or in inches as in 6.3x4in"
    )
    words.add_argument("--animate", action="store_true", help="also film the moving beam, as <stem>_motion.gif")
    return words


def size_of(text: str) -> tuple[float, float]:
    """Width and height in inches of `WxH` in mm, or of `WxHin`; raises `ArgumentTypeError` for other words."""
    found = re.fullmatch(r"(\d+(?:\.\d*)?)x(\d+(?:\.\d*)?)(mm|in)?", text)
    if not found:
        raise argparse.ArgumentTypeError(f"{text}: accepted: 160x100 (mm), 6.3x4in")
    unit = 1.0 if found[3] == "in" else MM
    size = float(found[1]) * unit, float(found[2]) * unit
    if not all(LEAST <= side <= MOST for side in size):
        raise argparse.ArgumentTypeError(f"{text}: accepted: sides of {LEAST:g} to {MOST:g} inches")
    return size


def main(argv: Sequence[str] | None = None) -> int:
    """Write the pictures of each file, or its page; 0, or 2 for wrong words, or 3 if any could not be drawn."""
    return command(parser(), _run, argv)


def _run(given: argparse.Namespace, tool: Tool) -> int:
    """Draw what was asked for; the highest exit status of any file."""
    names = [name for names in given.only for name in names.split(",") if name]
    if given.only and not names:
        raise WrongWords("--only names no picture; accepted: one or more names, or leave it out")
    given.only = names
    files, status = results_in(given, tool)
    _check(given, files)
    if not given.compare:
        refuse_repeated(files, given.output)
    if given.output is not None:
        make_directory(given.output)
    return max([status, *_drawn(given, tool, files)])


def results_in(given: argparse.Namespace, tool: Tool) -> tuple[list[Path], int]:
    """The results that the words stand for; the exit status is 3 where a directory is without one, which is said."""
    files: list[Path] = []
    status = EXIT_DONE
    for path in given.files:
        found = sorted(path.glob("*.nc")) if path.is_dir() else [path]
        files += found
        if not found:
            tool.complain(f"{path}: a directory without a result (*.nc)")
            status = EXIT_FILE
    return files, status


def _check(given: argparse.Namespace, files: list[Path]) -> None:
    """Raise `WrongWords` where words exclude each other."""
    if given.compare and len(files) != 2:
        raise WrongWords(f"--compare lays two results over each other; {len(files)} are given")
    if given.compare and (given.only or given.size):
        raise WrongWords("--compare draws all that two results share, of its own size: leave out --only and --size")
    if given.page and given.format != "png":
        raise WrongWords("--page holds its pictures itself: leave out --format")
    if given.compare and given.animate:
        raise WrongWords("--compare makes no film: leave out --animate")


def _drawn(given: argparse.Namespace, tool: Tool, files: list[Path]) -> Iterator[int]:
    """Draw what was asked for; the exit status of each part of it."""
    if given.compare:
        yield compare_files(tool, *files, given.output or files[0].parent, page=given.page, suffix=given.format)
        return
    unknown = [name for name in given.only if name not in KINDS]
    if unknown:
        yield from (name_pictures(tool, file, unknown) for file in files)
        return
    wish = Wish(tuple(given.only), given.format, given.size)
    places = [(file, given.output or file.parent) for file in files]
    for file, place in places:
        yield (
            page_file(tool, file, place / f"{file.stem}.html", wish) if given.page else draw_file(tool, file, place, wish)
        )
    for file, place in places if given.animate else ():
        yield film_file(tool, file, place / f"{file.stem}_motion.gif")


if __name__ == "__main__":
    sys.exit(main())
