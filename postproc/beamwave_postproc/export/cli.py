"""The command `beamwave-export`: hands the modal model of results to other programs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from ..cli import results_in
from ..files import write_from
from ..terminal import Words
from ..tool import EXIT_DONE, EXIT_FILE, EXIT_USAGE, PICTURE_SECONDS, Tool
from .formats import WRITERS
from .model import modal_model


def parser() -> argparse.ArgumentParser:
    """Return the words of the command line."""
    words = Words(prog="beamwave-export", description="Writes the modal model of beamwave results for other programs.")
    words.add_argument(
        "files", metavar="PATH", nargs="+", type=Path, help="a result of beamwave; a directory stands for its *.nc"
    )
    words.add_argument("--format", choices=sorted(WRITERS), default="npz", help="MATLAB, NumPy, or a universal file")
    words.add_argument("--case", metavar="N", type=int, help="of a sweep, the number of the case, from 1")
    words.add_argument("--output", metavar="DIR", type=Path, help="where the files go (default: beside each result)")
    words.add_argument("--overwrite", action="store_true", help="replace files that are there")
    return words


def main(argv: Sequence[str] | None = None) -> int:
    """Write the model of each result; 0, or 2 for wrong words, or 3 where one holds none or cannot be written."""
    given = parser().parse_args(argv)
    tool = Tool(overwrite=given.overwrite)
    return tool.run(lambda: _run(given, tool))


def _run(given: argparse.Namespace, tool: Tool) -> int:
    files, empty = results_in(given.files)
    for directory in empty:
        tool.complain(f"{directory}: a directory without a result (*.nc)")
    twice = sorted({file.stem for file in files if sum(other.stem == file.stem for other in files) > 1})
    if given.output is not None and twice:
        tool.complain(f"several results would write the same file: {', '.join(twice)}")
        return EXIT_USAGE
    if not tool.make_directory(given.output):
        return EXIT_FILE
    return max([EXIT_FILE if empty else EXIT_DONE, *(_export(given, tool, file) for file in files)])


def _export(given: argparse.Namespace, tool: Tool, source: Path) -> int:
    """Write the model of one result."""
    directory = given.output or source.parent
    case = "" if given.case is None else f"_case{given.case}"
    path = directory / f"{source.stem}{case}.{given.format}"

    def write(ds: xr.Dataset) -> None:
        tool.allow(PICTURE_SECONDS)
        model = modal_model(ds, given.case)
        title = str(ds.attrs.get("title", "")) or source.stem
        tool.save(path, lambda draft: WRITERS[given.format](model, draft, title))

    return write_from(tool, source, directory, write)


if __name__ == "__main__":
    sys.exit(main())
