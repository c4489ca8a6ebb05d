"""The command `beamwave-record`: files of laboratories into NetCDF files that `&record` reads."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from ..terminal import Words, printable
from ..tool import Tool, WrongWords, command, refuse_repeated
from ..writing import make_directory
from .channels import Channel, NotARecord, Wanted
from .readers import ACCEPTED, read_channels
from .write import grouped, write_record


def parser() -> argparse.ArgumentParser:
    """Return the words of the command line."""
    words = Words(
        prog="beamwave-record", description="Makes NetCDF files, which &record reads, of histories in other files."
    )
    words.add_argument("files", metavar="FILE", nargs="+", type=Path, help=f"{ACCEPTED}; told by content")
    words.add_argument("--output", metavar="DIR", type=Path, help="where the files go (default: beside each file)")
    words.add_argument("--overwrite", action="store_true", help="replace files that are there")
    words.add_argument(
        "--sample-rate", metavar="HZ", type=float, help="samples in a second, where the file does not say"
    )
    words.add_argument(
        "--time", metavar="NAME", help="array of the times (default: time or t), or number of a column or cell from 1"
    )
    words.add_argument(
        "--time-scale", metavar="S", type=float, default=1.0, help="seconds in the file's unit of time: 1e-3 for ms"
    )
    words.add_argument(
        "--date-order",
        choices=["day", "month"],
        help="which is first in dates such as 01/02/2024, where no number above 12 tells",
    )
    words.add_argument(
        "--variable", metavar="NAME", action="append", default=[], help="array of histories (default: all); repeatable"
    )
    words.add_argument("--points", metavar="XI", nargs="+", type=float, help="place of each sensor, x/l")
    words.add_argument("--unit", metavar="UNIT", help="unit of all histories, where the file does not say")
    words.add_argument(
        "--quantity",
        choices=["displacement", "velocity", "acceleration", "strain"],
        help="what all histories are, where the file does not say",
    )
    return words


def main(argv: Sequence[str] | None = None) -> int:
    """Write a NetCDF file for each file; 0, or 2 for wrong words, or 3 if any could not be read or written."""
    return command(parser(), _run, argv)


def _run(given: argparse.Namespace, tool: Tool) -> int:
    """Convert each file; the highest exit status of any."""
    _check(given)
    refuse_repeated(given.files, given.output)
    if given.output is not None:
        make_directory(given.output)
    places = [(file, given.output or file.parent) for file in given.files]
    return max(tool.each([file], place, partial(_convert, file, place, given, tool)) for file, place in places)


def _check(given: argparse.Namespace) -> None:
    """Raise `WrongWords` where a word is out of range or excludes another."""
    if given.sample_rate is not None and not 0 < given.sample_rate < float("inf"):
        raise WrongWords(f"--sample-rate is {given.sample_rate:g}; accepted: above 0")
    if given.sample_rate is not None and given.time is not None:
        raise WrongWords("--sample-rate excludes --time; accepted: one or the other")
    if not 0 < given.time_scale < float("inf"):
        raise WrongWords(f"--time-scale is {given.time_scale:g}; accepted: above 0")
    if given.sample_rate is not None and given.time_scale != 1.0:
        raise WrongWords("--sample-rate excludes --time-scale; accepted: one or the other")
    if given.points and not all(0 <= point <= 1 for point in given.points):
        raise WrongWords("--points are places x/l; accepted: 0 to 1")


def _convert(source: Path, directory: Path, given: argparse.Namespace, tool: Tool) -> None:
    """Make the records of one file in `directory`."""
    wanted = Wanted(given.sample_rate, given.time, given.variable, given.time_scale, given.date_order)
    channels = read_channels(source, wanted)
    groups = grouped(channels)
    for record in {channel.record for channel in channels}:
        _complete([channel for channel in channels if channel.record == record], given)
    for number, group in enumerate(groups, 1):
        end = ".nc" if len(groups) == 1 else f"_{number}.nc"
        path = directory / f"{source.stem}{end}"
        if path.exists() and path.samefile(source):
            raise NotARecord("its record would take its own place; accepted: another --output")
        write_record(group, path, f"beamwave-record, from {printable(source.name)}", overwrite=tool.overwrite)
        tool.say(str(path))
        for channel in group:
            quantity = channel.quantity or "unknown"
            tool.say(f"  {channel.name}: {channel.values.size} samples, {quantity} [{channel.unit}]")


def _complete(channels: list[Channel], given: argparse.Namespace) -> None:
    """Add what the caller says and the file does not. Raises `NotARecord` where places and sensors do not match."""
    if given.points and len(given.points) != len(channels):
        names = ", ".join(channel.name for channel in channels)
        raise NotARecord(f"--points has {len(given.points)} values, and there are {len(channels)} sensors: {names}")
    for number, channel in enumerate(channels):
        channel.unit = channel.unit or given.unit or ""
        channel.quantity = channel.quantity or given.quantity or ""
        channel.position = given.points[number] if given.points else None


if __name__ == "__main__":
    sys.exit(main())
