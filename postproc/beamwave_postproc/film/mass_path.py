"""Where the striking mass is: on the beam while it is attached, else in its guide, which turns with the hub."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from ..parts.contacts import free_flight, guide_rate, mass_in_contact, struck_mass
from ..parts.events import events_of

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


def mass_path(case: xr.Dataset, tip: Tip, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position of the mass (m) at `times`, and whether the tip holds it then; before the impact it approaches."""
    if "contact_force" in case:
        return _in_contact(case, tip, times)
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


def _in_contact(case: xr.Dataset, tip: Tip, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same where contacts last, whose forces move the mass; once it is captured it is on the tip."""
    captured = [event.time for event in events_of(case) if event.kind == "capture"]
    held = times >= min(captured, default=np.inf)
    return np.where(held, np.interp(times, tip.time, tip.displacement), mass_in_contact(case, times, tip.at(0.0)[0])), held


def _free(leg: Leg, rate: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity in the guide."""
    since = times - (leg.start if np.isfinite(leg.start) else 0.0)
    return free_flight(leg.position, leg.velocity, rate, since)


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
