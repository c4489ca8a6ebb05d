"""The numbers of a beam that were identified from the lines of its records."""

from __future__ import annotations

import re

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from ..parts.labels import INPUT_WORDS, symbol_of
from ..parts.sheet import Given, mosaic_for
from ..parts.units import LONG, number_text, si_prefix, unit_text
from ..result import NothingToDraw, require
from ..style import COLOURS, logarithmic, styled
from .record_model import verdict

ROW, LEAST = 0.85, 1.9  # inches, of an unknown, and of all
LIGHT = (0.2, 0.8)  # part of the map of colours on which black numbers are read
SAME_END = 1e-6  # of a range, within which an interval reaches its end
DECADE = 10.0  # from this ratio of its ends on a range has a logarithmic axis
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@styled
def identified(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw each identified number with its interval on an axis that spans its range, and the correlations of several.

    An interval that reaches an end of the range has an arrow there.
    """
    require(ds, "identified", "identified_low", "identified_high", "identified_correlation")
    if "identified_first" not in ds or not np.isfinite(ds["identified"].values).any():
        raise NothingToDraw("no range of what was identified")
    count = ds.sizes["unknown"]
    letters = [chr(ord("A") + i) for i in range(count)]
    several = count > 1
    layout = [3 * letter + "z" if several else letter for letter in letters]
    sheet = mosaic_for(ax, layout, [1.0] * count, width=7.6 if several else 6.4, height=max(LEAST, ROW * count))
    for i, axes in enumerate(sheet.axes[:1] + sheet.axes[2:] if several else sheet.axes):
        _draw_interval(axes, ds, i)
    if several:
        _draw_correlation(sheet.axes[1], ds["identified_correlation"].values)
    return sheet.finish(ds, ["intervals; each axis spans the range that was searched", *verdict(ds)])


def _draw_interval(axes: Axes, ds: xr.Dataset, i: int) -> None:
    """One unknown on its own axis, named above with its value and interval."""
    first, last, value, low, high = (
        float(ds[f"identified{word}"].values[i]) for word in ("_first", "_last", "", "_low", "_high")
    )
    unit = _text(ds["identified_unit"].values[i])
    prefix, factor = si_prefix(np.array([abs(value)]), unit)
    axes.errorbar(
        [factor * value],
        [0.0],
        xerr=[[factor * max(0.0, value - low)], [factor * max(0.0, high - value)]],
        capsize=5,
        marker="o",
        color=COLOURS[1],
        clip_on=False,
    )
    near = SAME_END * (last - first)
    ends = (not low > first + near, not high < last - near)  # a side that is not known is as open
    for end, reached, marker in zip((first, last), ends, "<>"):
        if reached:
            axes.plot([factor * end], [0.0], marker=marker, color=COLOURS[1], markersize=8, clip_on=False, zorder=3)
    if first > 0.0 and last >= DECADE * first:
        logarithmic(axes, "x", factor * first, factor * last)
    else:
        axes.set_xlim(factor * first, factor * last)
    axes.set(ylim=(-1.0, 1.0), yticks=[])
    axes.spines["left"].set_visible(False)
    number = f"{i + 1}  " if ds.sizes["unknown"] > 1 else ""
    words = _value_words(factor * value, factor * low, factor * high, ends, prefix + unit)
    axes.set_title(f"{number}{_name(_text(ds['identified_parameter'].values[i]))}:  {words}")
    axes.set_xlabel("")


def _draw_correlation(axes: Axes, correlation: np.ndarray) -> None:
    """Correlations of each two, below the diagonal, as numbers on light colours."""
    count = len(correlation)
    shown = np.where(np.tri(count, k=-1, dtype=bool), correlation, np.nan)[1:, :-1]
    light = ListedColormap(mpl.colormaps["RdBu_r"](np.linspace(*LIGHT, 256)))
    axes.imshow(shown, cmap=light, vmin=-1.0, vmax=1.0)
    for row, column in zip(*np.nonzero(np.isfinite(shown))):
        text = f"{shown[row, column]:.2f}".replace("-", "−")
        axes.text(column, row, text, ha="center", va="center", fontsize=9.0)
    axes.set(xticks=range(count - 1), yticks=range(count - 1), title="Correlation")
    axes.set_xticklabels(range(1, count))
    axes.set_yticklabels(range(2, count + 1))
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.grid(visible=False)


def _text(value: object) -> str:
    """A text of the file, which may be bytes."""
    return (value.decode() if isinstance(value, bytes) else str(value)).strip()


def _name(parameter: str) -> str:
    """An input, `group(number)%name(number)`, in words, with its symbol where it has one."""
    scene = re.search(r" (\(.*\))$", parameter)
    plain, number = re.subn(r"\((\d+)\)", r" \1 ", parameter.split(" ")[0])
    name = re.sub(r" \d+ ?", "", plain).replace("%", "_")
    words = INPUT_WORDS.get(name, "") if not number else ""
    words = words or re.sub(r"[%_ ]+", " ", plain).strip()
    symbol = symbol_of(name)
    parts = [words[:1].upper() + words[1:], symbol if "$" in symbol and not number else "", scene[1] if scene else ""]
    return " ".join(filter(None, parts))


def _value_words(value: float, low: float, high: float, ends: tuple[bool, bool], unit: str) -> str:
    """Value and interval of an unknown in its unit, with two digits of the interval's width.

    Of an interval that reaches one of the `ends` of the range the other side alone is told.
    """
    value, low, high = (_number(number, high - low) for number in (value, low, high))
    interval = {
        (False, False): f"({low} … {high})",
        (True, False): f"(at most {high})",
        (False, True): f"(at least {low})",
        (True, True): "(not fixed within the range)",
    }[ends]
    return f"{value} {interval} {unit_text(unit)}".strip()


def _number(number: float, width: float) -> str:
    """A number as exact as an interval of this width tells."""
    if not 0.0 < width < abs(number):
        return _power(number_text(number, 15 if width == 0.0 else 2))
    decimals = max(0, 1 - int(np.floor(np.log10(width))))
    return f"{number:.{decimals}f}" if abs(number) < LONG else _power(number_text(number, 2 + len(f"{number / width:.0f}")))


def _power(text: str) -> str:
    """1e9 as 10⁹, and 3e9 as 3·10⁹."""
    number, found, power = text.partition("e")
    if not found:
        return text
    return ("" if number == "1" else f"{number}·") + "10" + power.translate(SUPERSCRIPT)
