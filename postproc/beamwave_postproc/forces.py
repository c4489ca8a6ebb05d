"""The force of contacts as a file that `&force` reads: `python -m beamwave_postproc.forces FILE.nc …`.

Writes `<stem>_contact_force.csv` beside each result: time (s) and force (N) on the beam, of all contacts or of some.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from .files import write_from
from .parts.contacts import contacts_of
from .parts.passage import blow_at
from .parts.select import chosen, one_case
from .result import NothingToDraw, require
from .terminal import Words, printable
from .tool import Tool, command

FINE = 4  # times as many intervals as the file has: straight between its own points, a half sine would lose 1e-4 of its impulse
MARK = "contact force of the beamwave result"  # in the first line of a file, by which it is known as our own
COLUMNS = ("time [s]", "force [N]")


def forces(ds: xr.Dataset, contacts: Iterable[int] | None = None) -> pd.DataFrame:
    """Return time (s) and force (N) of the contacts of one case, or of those of these numbers from 1, for `&force shape = 'file'`.

    A contact's 128 values are at Chebyshev points; the polynomial through them is what lies between. The table has four
    times as many intervals, between which `&force` is straight, and 0 between contacts. What acts after a capture is no
    contact force. Raises `NothingToDraw` where a contact is not there.
    """
    require(ds, "contact_force")
    case, _ = one_case(ds)
    found = {contact.number: contact for contact in contacts_of(case)}
    numbers = sorted(found if contacts is None else set(contacts))
    if not set(numbers) <= set(found):
        raise NothingToDraw(f"the result has no contact {min(set(numbers) - set(found))}; it has {len(found)}, from {min(found)} to {max(found)}")
    parts = [_finer(found[number].time, found[number].force) for number in numbers]
    table = pd.DataFrame(np.hstack(parts).T, columns=COLUMNS)
    return table.drop_duplicates(COLUMNS[0], ignore_index=True)  # where a contact begins as the one before ends


def _finer(time: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Time and force at `FINE` times as many Chebyshev intervals, by the barycentric formula; the beam is never pulled."""
    count = force.size - 1
    nodes, places = (np.cos(np.pi * np.arange(n + 1) / n) for n in (count, FINE * count))
    weight = (-1.0) ** np.arange(count + 1)
    weight[[0, -1]] *= 0.5
    between = np.arange(places.size) % FINE > 0
    share = weight / (places[between, None] - nodes)
    values = np.empty(places.size)
    values[~between], values[between] = force, share @ force / share.sum(axis=1)
    return np.array([time[0] + (time[-1] - time[0]) * 0.5 * (1.0 - places), np.maximum(values, 0.0)])


def main(argv: Sequence[str] | None = None) -> int:
    """Write the tables; 0, or 3 if any of them could not be written."""
    words = Words(prog="python -m beamwave_postproc.forces", description=__doc__.splitlines()[0])
    words.add_argument("files", metavar="FILE.nc", nargs="+", type=Path, help="a result of beamwave with &contact")
    words.add_argument("--contact", metavar="N", type=int, action="append", help="this contact alone, from 1; repeatable (default: all)")
    words.add_argument("--case", metavar="N", type=int, default=1, help="case of a sweep, from 1 (default: 1)")
    words.add_argument("--overwrite", action="store_true", help="replace files that are there and are not its own")
    return command(words, lambda given, tool: max(_write(tool, file, given.case, given.contact) for file in given.files), argv)


def _write(tool: Tool, source: Path, number: int, contacts: list[int] | None) -> int:
    """Write the table of one file beside it, and say how a scene takes it; the exit status."""

    def write(ds: xr.Dataset) -> None:
        case = chosen(ds, cases=number) if "case" in ds.dims or number > 1 else ds
        table = forces(case, contacts)
        path = source.with_name(f"{source.stem}_contact_force.csv")

        def save(target: Path) -> None:
            with target.open("w", encoding="utf-8") as file:
                file.write(f"# {MARK} {printable(source.name)}\n")
                table.to_csv(file, index=False)

        tool.save(path, save, mark=MARK)
        tool.say(f"  &force position = {blow_at(case):g}, shape = 'file', file = '{path.name}' /")

    return write_from(tool, source, source.parent, write)


if __name__ == "__main__":
    sys.exit(main())
