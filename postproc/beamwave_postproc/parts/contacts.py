"""Contacts that last (`&contact`): their forces over time, and the way of the mass that follows from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from ..result import NothingToDraw, require
from .describe import turns_out_of_plane
from .events import events_of
from .section import beam_mass


class Contact(NamedTuple):
    """One contact: its number from 1, times (s) from its begin to its end, and the force (N) on the beam at these."""

    number: int
    time: np.ndarray
    force: np.ndarray

    @property
    def impulse(self) -> float:
        """Impulse on the beam, N s."""
        return float(np.sum(0.5 * np.diff(self.time) * (self.force[1:] + self.force[:-1])))


def contacts_of(case: xr.Dataset) -> list[Contact]:
    """The contacts of one case whose force is in the file, in their order; raises `NothingToDraw` without one."""
    require(case, "contact_force", "event_time", "event_end")
    end = float(case["time"][-1]) if "time" in case else np.nan
    count = case.sizes["contact_sample"]
    parts = 0.5 * (1.0 - np.cos(np.pi * np.arange(count) / (count - 1)))
    found, number = [], 0
    events = zip(*(case[name].values for name in ("contact_force", "event_time", "event_end")))
    for force, begin, until in events:
        until = until if np.isfinite(until) else end
        number += int(np.isfinite(force).any())
        if np.isfinite(force).all() and begin < until:
            found.append(Contact(number, begin + (until - begin) * parts, force))
    if not found:
        raise NothingToDraw("no contact force is in the file")
    return found


def guide_rate(case: xr.Dataset) -> float:
    """Rate ω at which the turning guide drives the mass outward, y'' = ω²y; 0 out of plane or without rotation."""
    if "rotation_angular_velocity" not in case or turns_out_of_plane(case):
        return 0.0
    return abs(float(case["rotation_angular_velocity"]))


def struck_mass(case: xr.Dataset) -> float:
    """Mass m_j (kg), given itself or by its ratio to the beam's."""
    if "impact_mass" in case:
        return float(case["impact_mass"])
    return float(case["impact_mass_ratio"]) * beam_mass(case)


def mass_in_contact(case: xr.Dataset, times: np.ndarray, start: float = 0.0) -> np.ndarray:
    """Position (m) at `times` of a mass that is free in its guide but for the forces of its contacts, and is at `start` at t = 0.

    The force is taken as an impulse in the middle of each interval of its samples, which errs by their squares. NaN where a base moves the
    mass, too, whose history no result holds.
    """
    if "applied_acceleration" in case:
        return np.full(np.shape(times), np.nan)
    mass, rate = struck_mass(case), guide_rate(case)
    starts, states = [0.0], [(start, float(case.get("impact_approach_velocity", 1.0)))]
    for contact in contacts_of(case):
        middles = 0.5 * (contact.time[1:] + contact.time[:-1])
        impulses = 0.5 * np.diff(contact.time) * (contact.force[1:] + contact.force[:-1])
        for moment, impulse in zip(middles, impulses):
            place, velocity = free_flight(*states[-1], rate, moment - starts[-1])
            starts.append(moment)
            states.append((float(place), float(velocity) - impulse / mass))
    last = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
    places, velocities = np.array(states).T
    return free_flight(places[last], velocities[last], rate, times - np.array(starts)[last])[0]


def mass_at_beam(case: xr.Dataset, times: np.ndarray, beam: np.ndarray, start: float = 0.0) -> np.ndarray:
    """Position (m) at `times` of the mass that strikes where the beam is at `beam`, and touches it at `start` at t = 0: from a capture on
    it moves with the beam, with the indentation that it has then. After a release it is NaN.
    """
    mass = mass_in_contact(case, times, start)
    events = {event.kind: event.time for event in reversed(events_of(case))}
    captured, released = (events.get(kind, np.inf) for kind in ("capture", "release"))
    if np.isfinite(captured):
        indentation = mass_in_contact(case, np.array([captured]), start)[0] - np.interp(captured, times, beam)
        mass = np.where(times >= captured, beam + indentation, mass)
    return np.where(times > released, np.nan, mass)


def free_flight(
    place: np.ndarray | float, velocity: np.ndarray | float, rate: float, since: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of a mass in its guide a time `since` (s) after it was at `place` with `velocity`."""
    if rate == 0.0:
        return place + velocity * since, velocity + 0.0 * since
    angle = np.clip(rate * since, -300.0, 300.0)
    grown, moved = np.cosh(angle), np.sinh(angle)
    return place * grown + velocity / rate * moved, velocity * grown + place * rate * moved
