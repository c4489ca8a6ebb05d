"""Words in a figure: how wide they are, and where their lines break."""

from __future__ import annotations

import re
from typing import Any

from matplotlib.figure import Figure


def width_of(fig: Figure, text: str, **style: Any) -> float:
    """Width in inches of one line as `fig` sets it."""
    artist = fig.text(0.0, 0.0, text, **style)
    width = artist.get_window_extent().width / fig.dpi
    artist.remove()
    return float(width)


def fitting(fig: Figure, parts: list[str], width: float, **style: Any) -> str:
    """As many of `parts`, the first ones foremost, as fit a line of `width` inches, with `…` for those left out."""
    gap, room = width_of(fig, "; ;", **style) - width_of(fig, ";", **style), width - width_of(fig, "; …", **style)
    shown: list[str] = []
    for part in parts:
        size = width_of(fig, part, **style) + gap
        if size <= room or not shown:
            shown.append(part)
            room -= size
    line = "; ".join([*shown, *["…"] * (len(shown) < len(parts))])
    whole = "; ".join(parts)
    return whole if width_of(fig, whole, **style) <= width else line


def broken(fig: Figure, text: str, width: float, **style: Any) -> str:
    """Break `text` at blanks outside formulas into lines of at most `width` inches, where its words allow it."""
    if width_of(fig, text, **style) <= width:
        return text
    blank = width_of(fig, "a a", **style) - width_of(fig, "aa", **style)
    lines: list[list[str]] = [[]]
    room = width
    for word in re.findall(r"(?:\$[^$]*\$|[^ ])+", text):
        size = width_of(fig, word, **style)
        if lines[-1] and size > room:
            lines.append([])
            room = width
        lines[-1].append(word)
        room -= size + blank
    return "\n".join(" ".join(line) for line in lines)
