"""The command `beamwave-plot`: draws what result files hold."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from .files import EXIT_DONE, EXIT_FILE, EXIT_USAGE, draw_file, film_file
from .kinds import pictures


def parser() -> argparse.ArgumentParser:
    """Return the words of the command line."""
    words = argparse.ArgumentParser(prog="beamwave-plot", description="Draws what beamwave results hold.")
    words.add_argument("files", metavar="FILE.nc", nargs="+", type=Path, help="a result of beamwave")
    words.add_argument("--output", metavar="DIR", type=Path, help="where the pictures go (default: beside each file)")
    words.add_argument("--animate", action="store_true", help="also film the moving beam, as <stem>_motion.gif")
    return words


def main(argv: Sequence[str] | None = None) -> int:
    """Write `<stem>_<kind>.png` for each picture of each file, and the film; 0, or 3 if any could not be drawn."""
    given = parser().parse_args(argv)
    if given.output is not None:
        twice = [stem for stem, count in Counter(file.stem for file in given.files).items() if count > 1]
        if twice:
            print(f"several files would write the same pictures: {', '.join(twice)}", file=sys.stderr)
            return EXIT_USAGE
        try:
            given.output.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            print(problem, file=sys.stderr)
            return EXIT_FILE
    done = [_plot(file, given.output or file.parent) for file in given.files]
    if given.animate:
        done += [film_file(file, (given.output or file.parent) / f"{file.stem}_motion.gif") for file in given.files]
    return EXIT_DONE if all(done) else EXIT_FILE


def _plot(file: Path, directory: Path) -> bool:
    """Draw all pictures of one file into `directory`; whether that went well."""

    def draw(ds: xr.Dataset) -> dict[Path, Figure]:
        return {directory / f"{file.stem}_{kind}.png": fig for kind, fig in pictures(ds).items()}

    return draw_file(file, draw)


if __name__ == "__main__":
    sys.exit(main())
