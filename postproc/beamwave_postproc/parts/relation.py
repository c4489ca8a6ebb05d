"""The dispersion relation of the Euler–Bernoulli beam in a rotating frame (Eqs 2, 32, 33)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from .describe import turns_out_of_plane
from .section import sections_of, tapers

# A result's modes obey Eq. 2 to rounding, or (tension, shear, damping) follow another relation.
SAME_RELATION = 1e-9


class Relation(NamedTuple):
    """β² = h²P⁴ − ω², with h = √(EI/(ρA)) in m² s⁻¹ and ω in rad s⁻¹ (0 where it does not enter)."""

    h: float
    omega: float

    def wavenumber(self, beta: np.ndarray) -> np.ndarray:
        """Wave number P (m⁻¹) of the angular frequency `beta` (rad s⁻¹): Eq. 2 solved for P."""
        return np.sqrt(np.hypot(beta, self.omega) / self.h)

    def value(self, name: str, beta: np.ndarray) -> np.ndarray:
        """The quantity called `name` in a result at angular frequency `beta`: β, Eq. 32 or Eq. 33."""
        if name == "angular_frequency":
            return beta
        p = self.wavenumber(beta)
        if name == "phase_velocity":
            return beta / p
        return 2.0 * self.h**2 * p**3 / beta


def bending_constant(case: xr.Dataset) -> float | None:
    """Return h = √(EI/(ρA)) in m² s⁻¹ of a uniform beam; None where the inputs are not there, or several by piece."""
    try:
        sections = sections_of(case)
    except KeyError:
        return None
    if len(sections) != 1 or tapers(case):
        return None
    (beam,) = sections
    return float(np.sqrt(beam.youngs_modulus / beam.density) * np.sqrt(beam.second_moment / beam.area))


def plain_relation(case: xr.Dataset) -> Relation | None:
    """Eq. 2 by the inputs of one case, whether or not its modes obey it; None where the beam is not uniform.

    Of a beam that bends out of the plane of rotation the angular velocity does not enter.
    """
    h = bending_constant(case)
    turns = "rotation_angular_velocity" in case and not turns_out_of_plane(case)
    return None if h is None else Relation(h, float(case["rotation_angular_velocity"]) if turns else 0.0)


def relation_of(case: xr.Dataset) -> Relation | None:
    """Return the relation that the modes of one case obey, with rotation or (out of plane) without; else None.

    The modes themselves decide, so that no curve is drawn through modes that do not lie on it.
    """
    by_inputs = plain_relation(case)
    if by_inputs is None:
        return None
    p, beta = case["wavenumber"].values, case["angular_frequency"].values
    known = np.isfinite(p) & np.isfinite(beta)
    elastic = by_inputs.h**2 * p[known] ** 4
    for omega in (by_inputs.omega, 0.0):
        if known.any() and np.allclose(beta[known] ** 2 + omega**2, elastic, rtol=SAME_RELATION, atol=0.0):
            return Relation(by_inputs.h, omega)
    return None
