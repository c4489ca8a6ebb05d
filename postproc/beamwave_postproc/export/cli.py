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
from ..tool import PICTURE_SECONDS, Tool, command, refuse_repeated
from ..writing import make_directory
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
    return command(parser(), _run, argv)


def _run(given: argparse.Namespace, tool: Tool) -> int:
    files, status = results_in(given, tool)
    refuse_repeated(files, given.output)
    if given.output is not None:
        make_directory(given.output)
    return max([status, *(_export(given, tool, file) for file in files)])


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
