"""A section of a document between two marks of its own, which a script replaces."""

from __future__ import annotations

from pathlib import Path

LAST = "<!-- to here -->"


def put_section(document: Path, first: str, text: str) -> None:
    """Replace what stands from the line `first` to the next LAST, or append it."""
    old = document.read_text(encoding="utf-8")
    before, begun, rest = old.partition(first + "\n")
    if begun:
        _, _, after = rest.partition(LAST + "\n")
    else:
        before, after = old.rstrip("\n") + "\n\n", ""
    document.write_text(f"{before}{first}\n{text.strip()}\n{LAST}\n{after}", encoding="utf-8")


def section(document: Path, first: str) -> str:
    """The text between the marks; empty where they are not."""
    _, _, rest = document.read_text(encoding="utf-8").partition(first + "\n")
    return rest.partition(LAST)[0].strip()


def table(rows: list[list[str]]) -> str:
    """A Markdown table, the first row its head, columns aligned for those who read the source."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |" for row in rows]
    return "\n".join([lines[0], "| " + " | ".join("-" * width for width in widths) + " |", *lines[1:]])


def measured_with(about: dict[str, str]) -> str:
    """The program, the Python and the day of a section; the rest stands once in the document, where the link leads."""
    said = [about["program"].split("; ")[0], *(f"{name} {about[name]}" for name in ("Python", "date") if name in about)]
    return f"Measured with {'; '.join(said)}. [Machine, compiler and flags](#where-it-was-measured)."
