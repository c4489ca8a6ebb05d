"""Units as they stand on axes and in words: UDUNITS text set as a quotient, and SI prefixes."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

PREFIXES = {"G": 1e-9, "M": 1e-6, "k": 1e-3, "": 1.0, "m": 1e3, "µ": 1e6, "n": 1e9, "p": 1e12}
# Which prefixes a unit takes, the largest first; a unit that is not here takes none.
TAKES = {
    "m": ("", "m", "µ", "n", "p"),
    "s": ("", "m", "µ", "n", "p"),
    "Hz": ("G", "M", "k", ""),
    "Pa": ("G", "M", "k", "", "m", "µ"),
    "N m": ("k", "", "m", "µ", "n"),
    "N s": ("", "m", "µ", "n"),
    "J": ("", "m", "µ", "n"),
    "rad": ("", "m", "µ"),
}
LARGEST = 1e300  # beyond which the margins of an axis may overflow
LEAST = 0.5  # a prefix suits if the largest number is at least this in it, k and beyond from 1 on
LONG = 1e6  # numbers from here on have a power of ten
RAISED = str.maketrans("0123456789.", "⁰¹²³⁴⁵⁶⁷⁸⁹·")


def units_of(variable: xr.DataArray) -> str:
    """UDUNITS text of a variable's unit; '1' where it has none."""
    return str(variable.attrs.get("units", "1"))


def unit_text(units: str) -> str:
    """UDUNITS text as a quotient: 'kg m-3' becomes kg/m³, 'm-1' 1/m, and '1' nothing. Other texts, as sensors have, stay."""
    if units == "1":
        return ""
    if not re.fullmatch(r"[A-Za-zµ%° \d.-]+", units):
        return units.replace("$", r"\$")
    above, below = [], []
    for name, power in re.findall(r"([A-Za-zµ%°]+)(-?\d+(?:\.\d+)?)?", units):
        size = (power or "1").lstrip("-")
        word = name + ("" if size == "1" else size.translate(RAISED))
        (below if power.startswith("-") else above).append(word)
    if not below:
        return " ".join(above)
    bottom = " ".join(below)
    return f"{' '.join(above) or '1'}/" + (f"({bottom})" if len(below) > 1 else bottom)


def drawable(variable: xr.DataArray) -> xr.DataArray:
    """The same, where what no axis can hold is missing."""
    return variable.where(np.abs(variable) < LARGEST)


def si_prefix(values: np.ndarray, units: str) -> tuple[str, float]:
    """SI prefix, and the factor to it, that suits the largest finite magnitude; none for units that take none."""
    finite = np.abs(values[np.isfinite(values)])
    largest = finite.max() if finite.size else 0.0
    for prefix in TAKES.get(units, ()):
        if largest * PREFIXES[prefix] >= (LEAST if PREFIXES[prefix] >= 1.0 else 1.0):
            return prefix, PREFIXES[prefix]
    return "", 1.0


def number_text(number: float, digits: int = 4, *, up: bool = False) -> str:
    """A number to so many digits, as the program's report has it: 9e-5, not 9e-05; a dash for what does not exist.

    With `up` a positive number is rounded up, as a bound must be.
    """
    if not np.isfinite(number):
        return "–"
    rounded = float(f"{number:.{digits}g}")
    if up and rounded < number:
        rounded = float(f"{rounded + 10.0 ** (np.floor(np.log10(number)) - digits + 1):.{digits}g}")
    text = f"{rounded:.15g}" if abs(rounded) < LONG else f"{rounded:.{digits}g}"
    return re.sub(r"e([+-])0*", lambda sign: f"e{sign.group(1).rstrip('+')}", text)


def with_unit(number: float, units: str, digits: int = 4, among: np.ndarray | None = None) -> str:
    """A number in its unit, with a prefix where that reads better, for it or for all `among` which it stands: 0.037 'm' becomes 37 mm.

    The blanks do not break.
    """
    prefix, factor = si_prefix(np.array([number]) if among is None else among, units)
    text = f"{number_text(number * factor, digits)}\u00a0{unit_text(prefix + units)}"
    return text.rstrip("\u00a0").replace(" ", "\u00a0")
