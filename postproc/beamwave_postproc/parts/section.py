"""The beam's cross-section, from whichever of its inputs a result holds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

SAME_PLACE = 1e-9  # of the beam's length


class Section(NamedTuple):
    """Section and material of one uniform piece; `reach`: neutral axis to outermost fibre, None if not known."""

    area: float  # m²
    second_moment: float  # m⁴
    reach: float | None  # m
    youngs_modulus: float  # Pa
    density: float  # kg/m³
    length: float  # m


def sections_of(case: xr.Dataset) -> list[Section]:
    """Sections of the beam's pieces, from the root outwards; raises `KeyError` where inputs are missing."""
    count = max((case[name].size for name in case.variables if str(name).startswith("beam_")), default=0)
    return [_section(case, piece) for piece in range(count)]


def sections_at(case: xr.Dataset, xi: float) -> list[Section]:
    """The section at ξ, or where two pieces meet both."""
    pieces = sections_of(case)
    ends = np.cumsum([piece.length for piece in pieces])
    ends /= ends[-1]
    starts = np.concatenate(([0.0], ends[:-1]))
    return [piece for piece, start, end in zip(pieces, starts, ends) if start - SAME_PLACE <= xi <= end + SAME_PLACE]


def _section(case: xr.Dataset, piece: int) -> Section:
    """Of one piece; what is the same for all pieces may be a single number."""

    def value(name: str) -> float:
        numbers = case[f"beam_{name}"].values.ravel()
        return float(numbers[piece if numbers.size > 1 else 0])

    if "beam_diameter" in case:
        diameter = value("diameter")
        area, second_moment, reach = np.pi / 4.0 * diameter**2, np.pi / 64.0 * diameter**4, diameter / 2.0
    elif "beam_height" in case:
        width, height = value("width"), value("height")
        area, second_moment, reach = width * height, width * height**3 / 12.0, height / 2.0
    else:
        area, second_moment, reach = value("area"), value("second_moment"), None
    return Section(area, second_moment, reach, value("youngs_modulus"), value("density"), value("length"))
