"""What the commands of bench/ share: words, where things are written, data from which table and picture are drawn."""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable

from overview import put_overview

from .document import put_section

BENCH = Path(__file__).parents[1]
PROJECT = BENCH.parent

Measured = dict[str, Any]


@dataclass(frozen=True)
class Bench:
    """A bench: how it measures, what it writes of the measured."""

    name: str
    about: str
    measure: Callable[[Path, bool], Measured]  # program, small
    first: str  # the mark in docs/numbers.md
    section: Callable[[Measured, str], str]  # measured, the picture's place beside the document
    save_picture: Callable[[Measured, Path], None]

    def data(self, output: Path | None = None) -> Path:
        """The measured numbers."""
        return output / f"{self.name}.json" if output else BENCH / self.name / "measured.json"


def main(bench: Bench) -> int:
    """Measure, and write data, section and picture."""
    words = arguments(bench)
    data = bench.data(words.output)
    document = (words.output or PROJECT / "docs") / "numbers.md"
    picture = f"pictures/{bench.name}.png"
    data.parent.mkdir(parents=True, exist_ok=True)
    if not words.redraw:
        data.write_text(as_text(bench.measure(words.beamwave.resolve(), words.small)), encoding="utf-8")
    measured = read(data)
    document.touch()
    put_section(document, bench.first, bench.section(measured, picture))
    bench.save_picture(measured, document.parent / picture)
    for row in measured["rows"]:
        if "not_measured" in row:
            print(f"{row['peer']}: not measured, {row['not_measured']}")
    if not words.output:
        put_overview()
    print(f"written: {data.name}, {picture} and a section of {document.name}")
    return 0


def arguments(bench: Bench) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog=f"bench/{bench.name}.sh", description=bench.about)
    parser.add_argument("--small", action="store_true", help="a few small sizes: does everything run?")
    parser.add_argument("--redraw", action="store_true", help="table and picture of the data that is there")
    parser.add_argument("--output", type=Path, help="write here and not into bench/ and docs/")
    parser.add_argument("--beamwave", type=Path, default=PROJECT / "build/bin/beamwave", help="the program")
    return parser.parse_args()


def read(data: Path) -> Measured:
    """The measured numbers of a file."""
    return json.loads(data.read_text(encoding="utf-8"))


def as_text(measured: Measured) -> str:
    """JSON with one row to a line."""
    rows = ",\n  ".join(json.dumps(row) for row in measured["rows"])
    head = json.dumps({**measured, "rows": []}, indent=1, ensure_ascii=False)
    return head.replace('"rows": []', f'"rows": [\n  {rows}\n ]') + "\n"
