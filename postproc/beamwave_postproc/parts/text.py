"""Words in a figure: how wide they are, and where their lines break."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

FONT = ("font.family", "font.sans-serif", "font.size", "mathtext.fontset")  # settings that a width depends on
DPI = 100.0


def width_of(text: str, **style: Any) -> float:
    """Width in inches of one line in a figure."""
    return _width(text, tuple(style.items()), tuple(str(mpl.rcParams[name]) for name in FONT))


@lru_cache(maxsize=4096)  # heads of one result's pictures have most words in common
def _width(text: str, style: tuple[tuple[str, Any], ...], _font: tuple[str, ...]) -> float:
    artist = _ruler().text(0.0, 0.0, text, **dict(style))
    width = artist.get_window_extent().width / DPI
    artist.remove()
    return float(width)


@lru_cache(maxsize=1)
def _ruler() -> Figure:
    """A figure on which words are measured."""
    return FigureCanvasAgg(Figure(dpi=DPI)).figure


def fitting(parts: list[str], width: float, lines: int = 1, **style: Any) -> str:
    """As many of `parts`, the first ones foremost, as fit `lines` of `width` inches, with `…` for those left out."""

    def fits(some: list[str]) -> bool:
        return broken("; ".join(some), width, **style).count("\n") < lines

    if fits(parts):
        return "; ".join(parts)
    shown: list[str] = []
    for part in parts:
        if not shown or fits([*shown, part, "…"]):
            shown.append(part)
    return "; ".join([*shown, "…"])


def broken(text: str, width: float, **style: Any) -> str:
    """Break `text` at blanks outside formulas into lines of at most `width` inches, where its words allow it."""
    if width_of(text, **style) <= width:
        return text
    blank = width_of("a a", **style) - width_of("aa", **style)
    lines: list[list[str]] = [[]]
    room = width
    for word in re.findall(r"(?:\$[^$]*\$|[^ ])+", text):
        size = width_of(word, **style)
        if lines[-1] and size > room:
            lines.append([])
            room = width
        lines[-1].append(word)
        room -= size + blank
    return "\n".join(" ".join(line) for line in lines)
