"""The modal model that a result holds where its scene has `&modes modal_model = .true.`."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from ..result import NothingToDraw

NEEDED = (
    *("modal_mass", "modal_stiffness", "modal_damping", "participation", "turn_participation", "moving_mass"),
    *("shape_at_points", "slope_at_points", "moment_at_points", "shear_at_points"),
    *("residual_flexibility", "residual_moment", "residual_shear"),
    *("residual_of_base", "residual_moment_of_base", "residual_shear_of_base"),
    *("initial_modal_displacement", "initial_modal_velocity"),
)
ON_HUB = ("hub_turn", "residual_hub_turn", "residual_hub_turn_of_base", "hub_radius")  # of a hub that is free
ABSENT = "the result holds no modal model; accepted: one of a scene with &modes modal_model = .true."


@dataclass(frozen=True)
class ModalModel:
    """Modes of one case with what forces at points and the base do to them, in SI.

    M q̈ + C q̇ + K q = Φᵀ F − P a, and v = Φ q + R F + R_a a, with forces F at the points and the acceleration a of the
    base. Arrays are (modes), (points), (modes, points), or (points, forces) with forces at the same points.

    On a hub that is free v is the displacement from its line, which turns by θ = θᵀ q + R_θ F + R_θa a; forces and the
    base drive modes by their whole motion, Φ + (R + x) θ.
    """

    position: np.ndarray  # x/l of the points
    distance: np.ndarray  # x, m
    mass: np.ndarray  # M, kg
    damping: np.ndarray  # C, N s/m
    stiffness: np.ndarray  # K, N/m; below zero of a mode that grows undamped
    participation: np.ndarray  # P = ∫ρAΦ dx and what bodies add, kg
    turn_participation: np.ndarray  # ∫ρAxΦ dx, with what turning sections and bodies add, kg m
    shape: np.ndarray  # Φ
    slope: np.ndarray  # Φ', with shear the turning of the section, 1/m
    moment: np.ndarray  # EIΦ'', N
    shear: np.ndarray  # shear force of the mode, N/m
    residual: dict[str, np.ndarray]  # what all other modes add under a force of 1 N, by quantity
    base_residual: dict[str, np.ndarray]  # and under an acceleration of the base by 1 m/s²
    moving_mass: float  # of beam and bodies, kg
    initial_displacement: np.ndarray  # q after all that happens at t = 0, m
    initial_velocity: np.ndarray  # and q̇, m/s
    hub_turn: np.ndarray | None = None  # of a hub that is free, and else without meaning: θ, 1/m
    hub_residual: np.ndarray | None = None  # what all other modes turn it by under a force of 1 N at each point, rad/N
    base_hub_residual: float = 0.0  # and under an acceleration of the base by 1 m/s², s²/m
    hub_radius: float = 0.0  # R, m

    @property
    def motion(self) -> np.ndarray:
        """Φ, on a hub that is free with its turn: what forces at the points drive."""
        if self.hub_turn is None:
            return self.shape
        return self.shape + np.outer(self.hub_turn, self.hub_radius + self.distance)

    @property
    def turning(self) -> np.ndarray:
        """Φ', on a hub that is free with its turn, 1/m: what moments at the points drive."""
        return self.slope if self.hub_turn is None else self.slope + self.hub_turn[:, np.newaxis]

    @property
    def angular_frequency(self) -> np.ndarray:
        """√(K/M), rad/s, that of the undamped motion; NaN of a mode that grows undamped."""
        square = self.stiffness / self.mass
        return np.sqrt(np.where(square >= 0.0, square, np.nan))

    @property
    def damping_ratio(self) -> np.ndarray:
        """C/(2√(KM)), above 1 of an overdamped mode; NaN where K is not above zero."""
        product = np.where(self.stiffness > 0.0, self.stiffness * self.mass, np.nan)
        return self.damping / (2.0 * np.sqrt(product))

    @property
    def effective_mass(self) -> np.ndarray:
        """P²/M, kg: with `residual_mass` they sum to `moving_mass`."""
        return self.participation**2 / self.mass

    @property
    def residual_mass(self) -> float:
        """What is left of the moving mass for all other modes, kg: they follow the base as a rigid body does."""
        return float(self.moving_mass - self.effective_mass.sum())


def modal_model(ds: xr.Dataset, case: int | None = None) -> ModalModel:
    """The modal model of a result, of a sweep that of one case, by its number.

    Raises `NothingToDraw` where the file holds none, or the case has no modes or is not there.
    """
    absent = [name for name in NEEDED if name not in ds]
    if absent:
        raise NothingToDraw(ABSENT if "modal_stiffness" in absent else f"the result holds no {', '.join(absent)}")
    one = _of_case(ds, case)
    count = int(np.isfinite(one.modal_stiffness.values).sum())
    if count == 0:
        raise NothingToDraw("no modes were found of this case; its notes say why")
    one = one.isel(mode=slice(count))
    position = one.point_position.values
    by_force = ("residual_flexibility", "residual_moment", "residual_shear")
    by_base = ("residual_of_base", "residual_moment_of_base", "residual_shear_of_base")
    quantities = ("displacement", "bending_moment", "shear_force")
    return ModalModel(
        position=position,
        distance=position * float(one.beam_length.sum()),
        mass=one.modal_mass.values,
        damping=one.modal_damping.values,
        stiffness=one.modal_stiffness.values,
        participation=one.participation.values,
        turn_participation=one.turn_participation.values,
        shape=one.shape_at_points.values,
        slope=one.slope_at_points.values,
        moment=one.moment_at_points.values,
        shear=one.shear_at_points.values,
        residual={what: one[name].transpose("point", "point_too").values for what, name in zip(quantities, by_force)},
        base_residual={what: one[name].values for what, name in zip(quantities, by_base)},
        moving_mass=float(one.moving_mass),
        initial_displacement=one.initial_modal_displacement.values,
        initial_velocity=one.initial_modal_velocity.values,
        **_of_hub(one),
    )


def _of_hub(one: xr.Dataset) -> dict[str, Any]:
    """What a model has of a hub that is free."""
    if any(name not in one for name in ON_HUB):
        return {}
    turn, residual, of_base, radius = (one[name].values for name in ON_HUB)
    return {"hub_turn": turn, "hub_residual": residual, "base_hub_residual": of_base.item(), "hub_radius": radius.item()}


def _of_case(ds: xr.Dataset, case: int | None) -> xr.Dataset:
    """One case of a sweep, or the only one."""
    if "case" not in ds.dims:
        if case not in (None, 1):
            raise NothingToDraw(f"the result has one case, and no case {case}")
        return ds
    if case is None:
        raise NothingToDraw(f"the result has {ds.sizes['case']} cases; accepted: --case, a number from 1")
    if not 1 <= operator.index(case) <= ds.sizes["case"]:
        raise NothingToDraw(f"the result has {ds.sizes['case']} cases, and no case {case}")
    return ds.isel(case=case - 1)
