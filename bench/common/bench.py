"""The frame of all benches: command line, data, section of docs/numbers.md and picture."""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable

from matplotlib.figure import Figure

from .document import put_section
from .machine import describe

BENCH = Path(__file__).parents[1]
PROJECT = BENCH.parent
PROGRAM = PROJECT / "build/bin/beamwave"

Measured = dict[str, Any]
Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class Bench:
    """What is a bench's own; the frame does the rest."""

    name: str
    about: str
    measure: Callable[[argparse.Namespace], Measured]  # its options: beamwave, small, machine, …
    section: Callable[[Measured], list[str]]  # paragraphs and tables
    draw: Callable[[Measured], Figure] | None = None
    packages: tuple[str, ...] = ()  # whose versions the section names
    options: dict[str, dict[str, Any]] | None = None  # more words of the command line

    @property
    def first(self) -> str:
        """The line of docs/numbers.md where its section begins."""
        return f"<!-- {self.name.replace('_', ' ')}: bench/{self.name}.sh writes from here -->"

    @property
    def picture(self) -> str:
        """Its place beside the document."""
        return f"pictures/{self.name}.png"

    def data(self, output: Path | None = None) -> Path:
        """The file of the measured numbers."""
        return output / f"{self.name}.json" if output else BENCH / self.name / "measured.json"

    def text(self, measured: Measured) -> str:
        """The section."""
        return "\n\n".join(part.strip() for part in self.section(measured))


def main(bench: Bench, arguments: list[str]) -> int:
    """Measure, and write data, section and picture."""
    options = read_words(bench, arguments)
    os.environ["BEAMWAVE"] = str(options.beamwave)
    data = bench.data(options.output)
    document = (options.output or PROJECT / "docs") / "numbers.md"
    data.parent.mkdir(parents=True, exist_ok=True)
    if not options.redraw:
        options.machine = describe(options.beamwave, bench.packages)
        measured = {"machine": options.machine, **bench.measure(options)}
        data.write_text(as_text(measured), encoding="utf-8")
    measured = read(data)
    document.touch()
    put_section(document, bench.first, bench.text(measured))
    if bench.draw:
        path = document.parent / bench.picture
        path.parent.mkdir(parents=True, exist_ok=True)
        bench.draw(measured).savefig(path, dpi=150, metadata={"Software": None})
    for row in measured["rows"]:
        if "not_measured" in row:
            print(f"{row['peer']}: not measured, {row['not_measured']}")
    if not options.output:
        from overview import put_overview

        put_overview()
    print(f"written: {data.name}, {bench.name} in {document.name}")
    return 0


def read_words(bench: Bench, arguments: list[str]) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog=f"bench/{bench.name}.sh", description=bench.about)
    parser.add_argument("--small", action="store_true", help="a few small sizes: does everything run?")
    parser.add_argument("--redraw", action="store_true", help="table and picture of the data that is there")
    parser.add_argument("--output", type=Path, help="write here and not into bench/ and docs/")
    parser.add_argument("--beamwave", type=lambda path: Path(path).resolve(), default=PROGRAM)
    for word, settings in (bench.options or {}).items():
        parser.add_argument(word, **settings)
    return parser.parse_args(arguments)


def read(data: Path) -> Measured:
    """The measured numbers of a file."""
    return json.loads(data.read_text(encoding="utf-8"))


def as_text(measured: Measured) -> str:
    """JSON with one row to a line."""
    text = json.dumps({**measured, "rows": []}, indent=1, ensure_ascii=False)
    rows = ",\n  ".join(json.dumps(row) for row in measured["rows"])
    return text.replace('"rows": []', f'"rows": [\n  {rows}\n ]') + "\n"
