"""The beam's cross-section, from whichever of its inputs a result holds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

SAME_PLACE = 1e-9  # of the beam's length


class Section(NamedTuple):
    """Section and material at a place of a piece; `reach`: neutral axis to outermost fibre, None if not known.

    Where the result knows ρA and EI alone (`is_lumped`) they stand as density and modulus, beside an area and a second moment of 1.
    """

    area: float  # m²
    second_moment: float  # m⁴
    reach: float | None  # m
    youngs_modulus: float  # Pa
    density: float  # kg/m³
    length: float  # m, of the piece
    is_lumped: bool = False


def tapers(case: xr.Dataset) -> bool:
    """Whether sections are those of stations, linear between them."""
    return any(case[name].size == case["beam_length"].size + 1 for name in _inputs(case))


def sections_of(case: xr.Dataset) -> list[Section]:
    """Sections of the beam's pieces, from the root outwards; those that taper in their middles.

    Raises `KeyError` where inputs are missing.
    """
    return [_section(case, piece, 0.5) for piece in range(_pieces(case))]


def sections_at(case: xr.Dataset, xi: float) -> list[Section]:
    """The section at ξ, or where two pieces meet both."""
    ends = np.cumsum([_section(case, piece, 0.5).length for piece in range(_pieces(case))])
    ends /= ends[-1]
    starts = np.concatenate(([0.0], ends[:-1]))
    return [
        _section(case, piece, min(1.0, max(0.0, (xi - start) / (end - start))))
        for piece, (start, end) in enumerate(zip(starts, ends))
        if start - SAME_PLACE <= xi <= end + SAME_PLACE
    ]


def beam_mass(case: xr.Dataset) -> float:
    """Mass of the beam (kg); raises `KeyError` where inputs are missing."""
    nodes = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)  # Gauss: exact for the cubic that ρA is at most
    sections = [_section(case, piece, x) for piece in range(_pieces(case)) for x in nodes]
    return sum(0.5 * section.density * section.area * section.length for section in sections)


def _inputs(case: xr.Dataset) -> list[str]:
    return [str(name) for name in case.variables if str(name).startswith("beam_")]


def _pieces(case: xr.Dataset) -> int:
    """How many pieces the beam has; 0 where nothing of it is known."""
    if "beam_length" not in case:
        return max((case[name].size for name in _inputs(case)), default=0)
    return case["beam_length"].size


def _section(case: xr.Dataset, piece: int, x: float) -> Section:
    """Of one piece, at x from 0 to 1 along it; what is the same for all pieces may be a single number."""
    count = _pieces(case)

    def value(name: str) -> float:
        numbers = case[f"beam_{name}"].values.ravel()
        if numbers.size > count:  # at stations
            return float((1.0 - x) * numbers[piece] + x * numbers[piece + 1])
        return float(numbers[piece if numbers.size > 1 else 0])

    reach = None
    is_lumped = "beam_mass_per_length" in case
    if is_lumped:
        area, second_moment = 1.0, 1.0
    elif "beam_diameter" in case:
        diameter = value("diameter")
        area, second_moment, reach = np.pi / 4.0 * diameter**2, np.pi / 64.0 * diameter**4, diameter / 2.0
    elif "beam_height" in case:
        width, height = value("width"), value("height")
        area, second_moment, reach = width * height, width * height**3 / 12.0, height / 2.0
    else:
        area, second_moment = value("area"), value("second_moment")
    if "beam_extreme_fibre" in case:
        reach = value("extreme_fibre")
    modulus = value("bending_stiffness" if is_lumped else "youngs_modulus")
    density = value("mass_per_length" if is_lumped else "density")
    return Section(area, second_moment, reach, modulus, density, value("length"), is_lumped)
