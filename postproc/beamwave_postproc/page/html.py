"""The page of a result: its report, notes and pictures in one HTML file."""

from __future__ import annotations

import base64
import io
from html import escape

import xarray as xr
from matplotlib.figure import Figure

from ..parts.describe import description_of, title_of
from ..parts.labels import plain
from ..parts.select import one_case
from ..parts.sheet import write_png
from ..writing import MARK
from .tables import Table, tables_of

DPI = 130
REMARK = "remark: "  # how a note of the file begins that is no warning
STYLE = """
body { font: 16px/1.45 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: .3rem; } h2 { font-size: 1.3rem; margin-top: 2.2rem; }
h3 { font-size: 1rem; margin: 1.4rem 0 .4rem; }
p.about { color: #555; margin-top: 0; } ul { padding-left: 1.2rem; }
table { border-collapse: collapse; font-size: .85rem; display: block; overflow-x: auto; }
th, td { padding: .2rem .6rem; text-align: right; }
td { white-space: nowrap; }
th { border-bottom: 1px solid #888; font-weight: 600; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; }
tbody tr:nth-child(even) td { background: #f6f6f6; }
pre { background: #f6f6f6; padding: .8rem; overflow-x: auto; font-size: .85rem; }
figure { margin: 1.5rem 0; overflow-x: auto; } img { max-width: 100%; min-width: 30rem; height: auto; }
@media print {
  body { margin: 0; max-width: none; } table { display: table; font-size: .6rem; } pre { white-space: pre-wrap; }
  figure, tr { break-inside: avoid; } h2, h3 { break-after: avoid; }
  figure { margin: .5rem 0; overflow: visible; } img { min-width: 0; max-height: 11.4cm; width: auto; }
}
"""


def page_of(ds: xr.Dataset, figures: dict[str, Figure]) -> str:
    """The HTML page of a result with these pictures, by kind: one text that refers to no other file."""
    case, which = one_case(ds)
    source = ", ".join(
        filter(None, (str(ds.attrs.get(name, "")) for name in ("source", "method", "created", "machine")))
    )
    parts = [
        f"<h1>{escape(title_of(ds))}</h1>",
        f'<p class="about">{escape(plain(description_of(ds)))}<br>{escape(source)}</p>',
    ]
    notes = [_note(note) for note in str(ds.attrs.get("notes", "")).splitlines() if note.strip()]
    if notes:
        parts += ["<h2>Notes</h2>", "<ul>", *notes, "</ul>"]
    parts.append("<h2>Report</h2>")
    if which:
        parts.append(f"<p>Of {escape(plain(which))}.</p>")
    parts += [_table(table) for table in tables_of(case)]
    parts += ["<h2>Pictures</h2>", *(_figure(kind, fig) for kind, fig in figures.items())]
    parts += ["<h2>Scene</h2>", f"<pre>{escape(str(ds.attrs.get('scene', '')).strip())}</pre>"]
    return _page(title_of(ds), parts)


def page_of_two(first: xr.Dataset, second: xr.Dataset, figures: dict[str, Figure], words: str) -> str:
    """The HTML page of two results laid over each other; `words` say in what they differ."""
    parts = [f"<h1>{escape(title_of(first))} — {escape(title_of(second))}</h1>"]
    for letter, ds in zip("AB", (first, second)):
        parts.append(f'<p class="about">{letter}: {escape(plain(description_of(ds)))}</p>')
    parts.append(f"<p>{escape(plain(words[:1].upper() + words[1:]))}.</p>")
    parts += [_figure(kind, fig) for kind, fig in figures.items()]
    return _page(f"{title_of(first)} — {title_of(second)}", parts)


def _page(title: str, parts: list[str]) -> str:
    """A whole document."""
    head = f'<meta charset="utf-8"><meta name="generator" content="{MARK}"><title>{escape(title)}</title>'
    view = '<meta name="viewport" content="width=device-width">'
    body = "\n".join(parts)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}{view}<style>{STYLE}</style></head>\n'
        f"<body>\n{body}\n</body></html>\n"
    )


def _note(note: str) -> str:
    """A note as the report has it: a warning, unless the file marks it as a remark."""
    words = note.removeprefix(REMARK)
    return f"<li><b>{'Warning' if words == note else 'Note'}:</b> {escape(words)}</li>"


def _table(table: Table) -> str:
    """One table with its title and note."""
    head = "".join(f"<th>{escape(_unit_whole(name))}</th>" for name in table.columns)
    rows = "\n".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows)
    note = f"<p>{escape(table.note)}</p>" if table.note else ""
    return f"<h3>{escape(table.title)}</h3>\n<table>\n<thead><tr>{head}</tr></thead>\n{rows}\n</table>{note}"


def _unit_whole(name: str) -> str:
    """The name of a column, whose words may stand below each other, but not the parts of its unit."""
    words, bracket, unit = name.partition("(")
    return words + bracket + unit.replace(" ", "\u00a0")


def _figure(kind: str, fig: Figure) -> str:
    """A picture, embedded, named by its kind."""
    image = io.BytesIO()
    write_png(fig, image, DPI)
    words = kind.replace("_", " ")
    data = base64.b64encode(image.getvalue()).decode("ascii")
    return f'<figure id="{kind}"><img alt="{words[:1].upper()}{words[1:]}" src="data:image/png;base64,{data}"></figure>'
