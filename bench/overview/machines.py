"""Where the numbers were measured: what all benches share stands once, what differs names its benches. The program's commit, the
packages of Python and the date stand in each section."""

from __future__ import annotations

from typing import Any

from common.document import table

HEAD = """\
## Where it was measured

Compiler and flags are those of the preset `default`."""

IN_SECTIONS = ("Python", "date")


def machines(measured: dict[str, Any]) -> str:
    """A table of one line for each thing that is known, or for each of its values."""
    found: dict[str, dict[str, list[str]]] = {}
    for bench, data in measured.items():
        for about in abouts(data):
            for name, value in parts(about):
                benches = found.setdefault(name, {}).setdefault(value, [])
                if bench not in benches:
                    benches.append(bench)
    rows = [["what", "value", "benches"]]
    for name, values in found.items():
        rows += [[name, value, "all" if len(benches) == len(measured) else ", ".join(benches)] for value, benches in values.items()]
    return f"{HEAD}\n\n{table(rows)}"


def abouts(data: dict[str, Any]) -> list[dict[str, str]]:
    """What a bench noted of its machine, or each of its parts."""
    own = [data[name] for name in ("machine", "about") if name in data]
    return own or [part["about"] for part in data.values() if isinstance(part, dict) and "about" in part]


def parts(about: dict[str, str]) -> list[tuple[str, str]]:
    """Names and values; of what the program says of itself, `; ` between its lines, those below the first."""
    found = []
    for name, value in about.items():
        if name == "program":
            found += [tuple(line.split(" ", 1)) for line in value.split("; ")[1:] if not line.startswith("compiler ")]
        elif name not in IN_SECTIONS:
            found.append((name, value))
    return found
