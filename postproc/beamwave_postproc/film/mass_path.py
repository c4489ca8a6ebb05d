"""Where the striking mass is: on the beam while it is attached, else in its guide, which turns with the hub."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from ..parts.describe import turns_out_of_plane
from ..parts.events import events_of
from ..parts.section import beam_mass


BODIES = ("arrival", "departure", "exchange")  # events of bodies, which the mass that strikes has no part in


@dataclass(frozen=True)
class Leg:
    """Part of the mass's way, from `start` on (s): free from `position` at `velocity`, or held by the tip."""

    start: float
    position: float = 0.0
    velocity: float = 0.0
    held: bool = False


@dataclass(frozen=True)
class Tip:
    """History of the beam's tip; its velocity by differences where the result does not hold it."""

    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray | None = None

    def at(self, time: float) -> tuple[float, float]:
        """Displacement and velocity just before `time`."""
        known = max(int(np.searchsorted(self.time, time, side="right")), 3)
        velocity = self.velocity
        if velocity is None:
            velocity = np.gradient(self.displacement[:known], self.time[:known], edge_order=2)
        return (
            float(np.interp(time, self.time, self.displacement)),
            float(np.interp(time, self.time[:known], velocity[:known])),
        )


def guide_rate(case: xr.Dataset) -> float:
    """Rate ω at which the turning guide drives the mass outward, y'' = ω²y; 0 out of plane or without rotation."""
    if "rotation_angular_velocity" not in case or turns_out_of_plane(case):
        return 0.0
    return abs(float(case["rotation_angular_velocity"]))


def mass_path(case: xr.Dataset, tip: Tip, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position of the mass (m) at `times`, and whether the tip holds it then; before the impact it approaches."""
    legs, rate = _legs(case, tip), guide_rate(case)
    position, held = np.empty(times.size), np.zeros(times.size, dtype=bool)
    for leg, following in zip(legs, [*legs[1:], None]):
        here = times >= leg.start
        if following is not None:
            here &= times < following.start
        held[here] = leg.held
        position[here] = (
            np.interp(times[here], tip.time, tip.displacement) if leg.held else _free(leg, rate, times[here])[0]
        )
    return position, held


def _free(leg: Leg, rate: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity in the guide."""
    since = times - (leg.start if np.isfinite(leg.start) else 0.0)
    if rate == 0.0:
        return leg.position + leg.velocity * since, np.full(times.shape, leg.velocity)
    angle = np.clip(rate * since, -300.0, 300.0)
    grown, moved = np.cosh(angle), np.sinh(angle)
    return leg.position * grown + leg.velocity / rate * moved, leg.velocity * grown + leg.position * rate * moved


def _legs(case: xr.Dataset, tip: Tip) -> list[Leg]:
    """The mass's way, event by event."""
    legs = [Leg(-np.inf, 0.0, float(case.get("impact_approach_velocity", 1.0)))]
    for event in events_of(case):
        if event.kind == "impact":
            legs.append(Leg(event.time, 0.0, float(case.get("mass_velocity", 0.0))))
        elif event.kind == "capture":
            legs.append(Leg(event.time, held=True))
        elif event.kind == "release":
            legs.append(Leg(event.time, *tip.at(event.time)))
        elif event.kind in BODIES:
            continue
        elif event.end > event.time:
            legs.append(Leg(event.time, held=True))
            if event.end < tip.time[-1]:
                legs.append(Leg(event.end, *tip.at(event.end)))
        else:
            before = _free(legs[-1], guide_rate(case), np.array([event.time]))[1]
            legs.append(Leg(event.time, tip.at(event.time)[0], float(before[0]) - event.impulse / struck_mass(case)))
    return legs


def struck_mass(case: xr.Dataset) -> float:
    """Mass m_j (kg), given itself or by its ratio to the beam's."""
    if "impact_mass" in case:
        return float(case["impact_mass"])
    return float(case["impact_mass_ratio"]) * beam_mass(case)
