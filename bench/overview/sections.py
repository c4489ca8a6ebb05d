"""Puts both into the document, from the committed data of all benches and the table of hard cases in the document itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from common.document import put_section

from .machines import machines
from .what_matters import what_matters

BENCH = Path(__file__).parents[1]
DOCUMENT = BENCH.parent / "docs/numbers.md"
NAMES = ("peers", "contact", "growth", "throughput", "price", "effects", "sum", "records", "large_records")
FIRST = "<!-- what matters: every bench writes from here -->"
LAST = "<!-- machines: every bench writes from here -->"


def put_overview() -> None:
    """Write both sections anew."""
    measured = committed()
    put_section(DOCUMENT, FIRST, what_matters(measured, DOCUMENT.read_text(encoding="utf-8")))
    put_section(DOCUMENT, LAST, machines(measured))


def committed() -> dict[str, Any]:
    """The data of each bench that has any."""
    files = {name: BENCH / name / "measured.json" for name in NAMES}
    return {name: json.loads(path.read_text(encoding="utf-8")) for name, path in files.items() if path.is_file()}
