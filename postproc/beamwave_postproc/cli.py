"""The command `beamwave-plot`: draws what result files hold."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from .files import EXIT_DONE, EXIT_FILE, EXIT_USAGE, compare_files, draw_file, film_file, page_file
from .kinds import pictures


def parser() -> argparse.ArgumentParser:
    """Return the words of the command line."""
    words = argparse.ArgumentParser(prog="beamwave-plot", description="Draws what beamwave results hold.")
    words.add_argument(
        "files", metavar="PATH", nargs="+", type=Path, help="a result of beamwave; a directory stands for its *.nc"
    )
    words.add_argument("--output", metavar="DIR", type=Path, help="where the pictures go (default: beside each file)")
    words.add_argument(
        "--page", action="store_true", help="one HTML page with report, notes and pictures instead, <stem>.html"
    )
    words.add_argument("--compare", action="store_true", help="lay two results over each other")
    words.add_argument("--animate", action="store_true", help="also film the moving beam, as <stem>_motion.gif")
    return words


def main(argv: Sequence[str] | None = None) -> int:
    """Write the pictures of each file, or its page; 0, or 2 for wrong words, or 3 if any could not be drawn."""
    given = parser().parse_args(argv)
    files, empty = results_in(given.files)
    for directory in empty:
        print(f"{directory}: a directory without a result (*.nc)", file=sys.stderr)
    problem = _problem(given, files)
    if problem:
        print(problem, file=sys.stderr)
        return EXIT_USAGE
    if given.output is not None:
        try:
            given.output.mkdir(parents=True, exist_ok=True)
        except OSError as failure:
            print(failure, file=sys.stderr)
            return EXIT_FILE
    done = _drawn(given, files)
    return EXIT_DONE if all(done) and not empty else EXIT_FILE


def results_in(paths: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """The files that `paths` stand for, and those directories that hold no result."""
    files: list[Path] = []
    empty = []
    for path in paths:
        found = sorted(path.glob("*.nc")) if path.is_dir() else [path]
        files += found
        empty += [] if found else [path]
    return files, empty


def _problem(given: argparse.Namespace, files: list[Path]) -> str:
    """What is wrong with the words; empty if nothing is."""
    if given.compare and len(files) != 2:
        return f"--compare lays two results over each other; {len(files)} are given"
    if given.compare and given.animate:
        return "--compare makes no film: leave out --animate"
    twice = [stem for stem, count in Counter(file.stem for file in files).items() if count > 1]
    if given.output is not None and not given.compare and twice:
        return f"several files would write the same pictures: {', '.join(twice)}"
    return ""


def _drawn(given: argparse.Namespace, files: list[Path]) -> list[bool]:
    """Draw what was asked for; whether each part of it went well."""
    if given.compare:
        return [compare_files(*files, given.output or files[0].parent, page=given.page)]
    places = [(file, given.output or file.parent) for file in files]
    done = [
        page_file(file, place / f"{file.stem}.html") if given.page else _plot(file, place) for file, place in places
    ]
    if given.animate:
        done += [film_file(file, place / f"{file.stem}_motion.gif") for file, place in places]
    return done


def _plot(file: Path, directory: Path) -> bool:
    """Draw all pictures of one file into `directory`; whether that went well."""

    def draw(ds: xr.Dataset) -> dict[Path, Figure]:
        return {directory / f"{file.stem}_{kind}.png": fig for kind, fig in pictures(ds).items()}

    return draw_file(file, draw)


if __name__ == "__main__":
    sys.exit(main())
