"""What the beam carries in a film: bodies on it and on their way, a joint that locks, and the modes meanwhile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from ..parts.events import Event
from ..parts.line import SAME_PLACE, is_clamped
from ..parts.places import bodies_there, body_places
from ..parts.units import with_unit
from .mass_path import BODIES, Tip

SAME_TIME = 1e-9  # relative: of an event and of the input that it comes from


@dataclass(frozen=True)
class Carried:
    """Bodies in each frame. Places x along the beam and deflections in m."""

    place: np.ndarray  # where something is attached at some time, (places)
    there: np.ndarray  # whether it is, (frames, places)
    free_place: np.ndarray  # of the bodies that come or leave, (bodies)
    free: np.ndarray  # deflection of these before and after, NaN on the beam, (frames, bodies)
    locked: np.ndarray  # whether a spring locks the joint at the root, (frames)


@dataclass(frozen=True)
class _Body:
    """One `&body`: place ξ, from when until when (s), the velocity it brings (NaN: the beam's), what it is."""

    place: float
    begin: float
    end: float
    velocity: float
    locks: bool  # a spring at the joint, without mass
    is_free: bool  # it has mass and no springs


def carried_in(case: xr.Dataset, moments: np.ndarray, length: float) -> Carried:
    """What the beam of one case carries at `moments` (s)."""
    bodies = _bodies(case)
    locks = np.array([body.locks for body in bodies], dtype=bool)
    kept = case.isel(body=np.flatnonzero(~locks)) if locks.any() else case
    flights = [(body.place * length, _flight(case, body, moments)) for body in bodies if body.is_free]
    flights = [(place, flight) for place, flight in flights if np.isfinite(flight).any()]
    locked = [(moments >= body.begin) & (moments < body.end) for body in bodies if body.locks]
    return Carried(
        place=body_places(kept) * length,
        there=bodies_there(kept, moments),
        free_place=np.array([place for place, _ in flights]),
        free=np.array([flight for _, flight in flights]).reshape(-1, moments.size).T,
        locked=np.any(locked, axis=0) if locked else np.zeros(moments.size, dtype=bool),
    )


def named(case: xr.Dataset, event: Event) -> tuple[Event, list[float] | None]:
    """An event of bodies in words of what comes or leaves, and the places ξ of that; of other events no places."""
    if event.kind not in BODIES:
        return event, None
    words, places = [], []
    for body in _bodies(case):
        for time, of_joint, of_body in ((body.end, "joint opens", "body leaves"), (body.begin, "joint locks", "body arrives")):
            if np.isclose(time, event.time, rtol=SAME_TIME, atol=0.0):
                words.append(of_joint if body.locks else of_body)
                places.append(body.place)
    return event._replace(kind=", ".join(dict.fromkeys(words)) or event.kind), places


def first_mode(case: xr.Dataset, moments: np.ndarray) -> list[str]:
    """Frequency of mode 1 at `moments` in words, of a beam that changes; else nothing."""
    if "configuration_start" not in case or case.sizes["configuration"] < 2:
        return [""] * moments.size
    starts = case["configuration_start"].fillna(np.inf).values
    hertz = case["configuration_angular_frequency"].values[:, 0] / (2.0 * np.pi)
    words = [_frequency(value) for value in hertz]
    return [words[max(np.searchsorted(starts, moment, side="right") - 1, 0)] for moment in moments]


def _frequency(hertz: float) -> str:
    if not np.isfinite(hertz):
        return "mode 1 does not oscillate"
    return f"mode 1: {with_unit(hertz, 'Hz')}" if hertz > 0.0 else "mode 1: rigid body"


def _bodies(case: xr.Dataset) -> list[_Body]:
    """The bodies of one case; of a sweep over their places none."""
    if "body_position" not in case or "case" in case["body_position"].dims:
        return []
    position = np.atleast_1d(case["body_position"].values)

    def values(name: str, absent: float) -> np.ndarray:
        variable = f"body_{name}"
        return np.broadcast_to(case[variable].fillna(absent).values if variable in case else absent, position.shape)

    mass = values("mass", 0.0) + values("mass_ratio", 0.0)
    spring, turning = values("stiffness", 0.0), values("rotational_stiffness", 0.0)
    locks = (position == 0.0) & (mass == 0.0) & (turning > 0.0) & (not is_clamped(case))
    is_free = (mass > 0.0) & (spring + turning == 0.0)
    columns = position, values("from", -np.inf), values("until", np.inf), values("velocity", np.nan), locks, is_free
    return [_Body(*row) for row in zip(*(column.tolist() for column in columns))]


def _flight(case: xr.Dataset, body: _Body, moments: np.ndarray) -> np.ndarray:
    """Deflection of a body before it comes with a velocity of its own, and after it has left; else NaN.

    Also NaN without a point at its place, and where the beam rotates: a body that is free does not stay beside its place then.
    """
    flight = np.full(moments.size, np.nan)
    near = np.flatnonzero(np.abs(case["point_position"].values - body.place) < SAME_PLACE)
    time = case["time"].values
    rotates = "rotation_angular_velocity" in case and float(case["rotation_angular_velocity"]) != 0.0
    if rotates or not near.size or time.size < 3:
        return flight
    beam = Tip(time, case["displacement"].values[near[0]])
    if time[0] < body.begin < time[-1] and np.isfinite(body.velocity):
        before = moments < body.begin
        flight[before] = beam.at(body.begin)[0] + body.velocity * (moments[before] - body.begin)
    if time[0] < body.end < time[-1]:
        after = moments >= body.end
        place, velocity = beam.at(body.end)
        flight[after] = place + velocity * (moments[after] - body.end)
    return flight
