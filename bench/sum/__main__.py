"""Modes and their sum beside numpy + FINUFFT: a table of times and errors."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from common.command import PROJECT, as_text
from common.document import put_section
from common.machine import describe
from overview import put_overview

from .compare import REPEATS, measure
from .library import Beamwave
from .section import FIRST, section

DATA = Path(__file__).with_name("measured.json")


def main() -> None:
    words = argparse.ArgumentParser(prog="bench/sum.sh", description=__doc__)
    words.add_argument("--small", action="store_true", help="one small size, printed: does everything run?")
    words.add_argument("--redraw", action="store_true", help="the section of the data that is there")
    words.add_argument("--repeats", type=int, default=REPEATS, help="turns of every size")
    words.add_argument("--beamwave", type=Path, default=PROJECT / "build/bin/beamwave", help="the program")
    given = words.parse_args()
    program = given.beamwave.resolve()
    if given.redraw:
        measured = json.loads(DATA.read_text(encoding="utf-8"))
    else:
        about = {**describe(program, ("numpy", "finufft")), "date": time.strftime("%Y-%m-%d")}
        rows = measure(Beamwave(program.parents[1]), given.small, given.repeats)
        measured = {"about": about, "repeats": given.repeats, "rows": rows}
    print(section(measured))
    if given.small:
        return
    DATA.write_text(as_text(measured), encoding="utf-8")
    put_section(PROJECT / "docs/numbers.md", FIRST, section(measured))
    put_overview()


if __name__ == "__main__":
    main()
